//! Server of the lab: sends the files of the page, and opens a WebSocket for each page. It accepts connections from
//! this machine only. The address of the page contains a token, a random text that every request must contain.

use super::access::{Token, is_host, is_origin};
use super::engine_lock::EngineLock;
use super::live::LiveFeed;
use super::live_session::serve_live;
use super::page::{ASSETS, Asset, LIVE, LIVE_POLICY, POLICY};
use super::protocol::{Ask, LONGEST};
use super::session::{PageMessage, Session};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::ws::{self, WebSocket, WebSocketUpgrade};
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, Response, StatusCode, header};
use axum::middleware::{self, Next};
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{Semaphore, mpsc, watch};

/// Largest number of pages of the lab that may be open at the same time.
const MOST_SESSIONS: usize = 4;

/// Largest number of requests of a page that wait until the session of this page (the thread that runs its panels)
/// reads them. If a page sends more, its connection is closed.
const MOST_ASKS: usize = 256;

/// Largest number of messages that wait until the WebSocket of a page sends them. If so many messages wait, the session
/// of the page (the thread that runs its panels) waits too.
const UNSENT: usize = 4;

/// Largest number of simultaneous connections, not counting WebSockets. A page opens six connections, and many systems
/// allow a process only 64 open files.
const MOST_CONNECTIONS: usize = 40;

/// Longest time from the connection of a page, or from the previous answer, to the end of the head of its next request.
/// A page on this machine sends the head at once.
const HEAD: Duration = Duration::from_secs(2);

/// Longest duration of a connection, after which the connection is closed. A page opens a new connection if it needs
/// one.
const CONNECTION: Duration = Duration::from_secs(60);

/// Pause before the next attempt to accept a connection, after the system has reported an error.
const AFTER_ERROR: Duration = Duration::from_millis(100);

/// Reason why the server of the lab cannot start.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// The server cannot listen at the port, for example because another program uses it.
    #[error("cannot listen at port {port} of this machine: {why}\nhelp: leave --port out to get a free one")]
    Port {
        /// Number of the port; 0 means any free port.
        port: u16,
        /// Error of the operating system.
        why: std::io::Error,
    },
    /// The operating system gives no random numbers for the token.
    #[error("cannot make a token for the address: {0}")]
    Token(#[from] getrandom::Error),
    /// The operating system gives no thread or no event loop for the server.
    #[error("cannot start the server: {0}")]
    Start(std::io::Error),
}

/// Running server of the lab.
pub struct LabServer {
    address: SocketAddr,
    token: Token,
    sessions: Arc<AtomicUsize>,
    stop: watch::Sender<bool>,
    server: JoinHandle<()>,
}

/// Data that all requests to the server share. A clone refers to the same data.
#[derive(Clone)]
struct ServerState {
    port: u16,
    token: Token,
    turn: EngineLock,
    sessions: Arc<AtomicUsize>,
    threads: Arc<Mutex<Vec<JoinHandle<()>>>>,
    stop: watch::Receiver<bool>,
    /// Frames of the run that the server shows in place of the scenes of the lab; `None` if it shows the scenes.
    feed: Option<Arc<LiveFeed>>,
}

impl LabServer {
    /// Starts a server at the port `port` of this machine; 0 means any free port. The server runs until
    /// [`stop`](Self::stop) is called.
    ///
    /// # Errors
    /// Returns an error if the port is taken, or if the system gives no random numbers or no thread.
    pub fn start(port: u16) -> Result<Self, LabError> {
        Self::serving(port, None)
    }

    /// Starts a server that shows a run, in place of the scenes of the lab. The server uses any free port of this
    /// machine.
    ///
    /// # Errors
    /// Errors of [`start`](Self::start).
    pub fn start_live(feed: Arc<LiveFeed>) -> Result<Self, LabError> {
        Self::serving(0, Some(feed))
    }

    fn serving(port: u16, feed: Option<Arc<LiveFeed>>) -> Result<Self, LabError> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|why| LabError::Port { port, why })?;
        let address = listener.local_addr().map_err(LabError::Start)?;
        listener.set_nonblocking(true).map_err(LabError::Start)?;
        let (stop, stopped) = watch::channel(false);
        let shared = ServerState {
            port: address.port(),
            token: Token::new()?,
            turn: EngineLock::default(),
            sessions: Arc::default(),
            threads: Arc::default(),
            stop: stopped,
            feed,
        };
        let (token, sessions) = (shared.token.clone(), Arc::clone(&shared.sessions));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
        let runtime = runtime.map_err(LabError::Start)?;
        let serve = move || runtime.block_on(serve(listener, shared));
        let server = std::thread::Builder::new().name("lab server".into()).spawn(serve).map_err(LabError::Start)?;
        Ok(Self { address, token, sessions, stop, server })
    }

    /// Address of the lab, which the user opens in a browser. The address contains the token (secret text).
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token.as_str())
    }

    /// IP address and port at which the server listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Number of pages that are open at present.
    pub fn sessions(&self) -> usize {
        self.sessions.load(Ordering::SeqCst)
    }

    /// Stops the server. Waits until the server and all threads that it has started have ended.
    pub fn stop(self) {
        // errors are ignored: the server may have ended already, and a thread that has panicked has printed a message
        let _ = self.stop.send(true);
        let _ = self.server.join();
    }
}

/// Answers requests until the server is stopped, and then waits for the threads of all sessions to end.
async fn serve(listener: TcpListener, shared: ServerState) {
    let (mut stop, threads) = (shared.stop.clone(), Arc::clone(&shared.threads));
    let checked = middleware::from_fn_with_state(shared.clone(), check);
    let router = Router::new()
        .route("/{token}/", get(index))
        .route("/{token}/socket", get(socket))
        .route("/{token}/{file}", get(file))
        .layer(checked)
        .with_state(shared);
    if let Ok(listener) = tokio::net::TcpListener::from_std(listener) {
        tokio::select! {
            () = accept(listener, router) => {}
            () = until_told(&mut stop) => {}
        }
    }
    // when the server is stopped, each WebSocket is closed, and the session of its page then ends
    let threads = std::mem::take(&mut *threads.lock().unwrap_or_else(PoisonError::into_inner));
    for thread in threads {
        while !thread.is_finished() {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        let _ = thread.join();
    }
}

/// Accepts connections and answers their requests. The number of connections and the duration of each one are limited.
/// Further connections wait until an earlier one has ended.
async fn accept(listener: tokio::net::TcpListener, router: Router) {
    let places = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    while let Ok(place) = Arc::clone(&places).acquire_owned().await {
        let Ok((stream, _)) = listener.accept().await else {
            // after an error such as too many open files, the pause leaves time for other connections to close
            tokio::time::sleep(AFTER_ERROR).await;
            continue;
        };
        let service = TowerToHyperService::new(router.clone());
        tokio::spawn(async move {
            let mut server = http1::Builder::new();
            server.timer(TokioTimer::new()).header_read_timeout(HEAD);
            // after a page has opened its WebSocket, the function `socket` serves this WebSocket
            let connection = server.serve_connection(TokioIo::new(stream), service).with_upgrades();
            // a connection that breaks off or times out is not an error of the server
            drop(tokio::time::timeout(CONNECTION, connection).await);
            drop(place);
        });
    }
}

/// Waits until the server is told to stop.
pub(super) async fn until_told(stop: &mut watch::Receiver<bool>) {
    // an error means that the `LabServer` no longer exists, so the server must stop
    drop(stop.wait_for(|stop| *stop).await);
}

/// Answer that consists of a status code and its standard text.
fn plain(status: StatusCode) -> Response<Body> {
    let mut response = Response::new(Body::from(status.canonical_reason().unwrap_or_default()));
    *response.status_mut() = status;
    response
}

/// Text of the header `name` if the request contains this header exactly once; `None` otherwise. If a header occurs
/// several times, programs may disagree on its value.
fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    let mut all = headers.get_all(name).iter();
    let only = all.next().filter(|_| all.next().is_none())?;
    only.to_str().ok()
}

/// Refuses a request that names another host than this machine, comes from the page of another site, or lacks the token
/// (secret text of the address). Every answer gets headers that isolate the page from other pages.
async fn check(State(shared): State<ServerState>, request: Request, next: Next) -> Response<Body> {
    let headers = request.headers();
    let upgrade = headers.contains_key(header::UPGRADE);
    let (host, origin) = (text(headers, header::HOST), text(headers, header::ORIGIN));
    let origin_known =
        is_origin(origin, shared.port, upgrade) && (origin.is_some() || !headers.contains_key(header::ORIGIN));
    let token = request.uri().path().split('/').nth(1).unwrap_or_default();
    let mut response = if !is_host(host, shared.port) || !origin_known {
        plain(StatusCode::FORBIDDEN)
    } else if !shared.token.is(token) {
        plain(StatusCode::NOT_FOUND)
    } else {
        next.run(request).await
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, if shared.feed.is_some() { LIVE_POLICY } else { POLICY }),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        response.headers_mut().insert(name, header::HeaderValue::from_static(value));
    }
    response
}

async fn index(State(shared): State<ServerState>) -> Response<Body> {
    asset(if shared.feed.is_some() { Some(&LIVE) } else { ASSETS.first() })
}

async fn file(Path((_, file)): Path<(String, String)>) -> Response<Body> {
    asset(ASSETS.iter().find(|asset| asset.path == file))
}

/// Answer with a file of the page, or with status 404 if `asset` is `None`, because there is no such file.
fn asset(asset: Option<&Asset>) -> Response<Body> {
    let Some(asset) = asset else { return plain(StatusCode::NOT_FOUND) };
    let mut response = Response::new(Body::from(asset.text));
    response.headers_mut().insert(header::CONTENT_TYPE, header::HeaderValue::from_static(asset.kind));
    response
}

/// Opens the WebSocket of a page. If too many pages are open, the answer is status 503.
async fn socket(State(shared): State<ServerState>, upgrade: WebSocketUpgrade) -> Response<Body> {
    let taken = shared
        .sessions
        .fetch_update(Ordering::SeqCst, Ordering::SeqCst, |open| (open < MOST_SESSIONS).then_some(open + 1));
    if taken.is_err() {
        return plain(StatusCode::SERVICE_UNAVAILABLE);
    }
    let place = PageSlot(Arc::clone(&shared.sessions));
    upgrade.max_message_size(LONGEST).max_frame_size(LONGEST).on_upgrade(move |socket| async move {
        match shared.feed.clone() {
            Some(feed) => {
                serve_live(socket, &feed, shared.stop.clone()).await;
                drop(place);
            }
            None => serve_page(socket, shared, place).await,
        }
    })
}

/// Permission for one open page. The number of permissions is limited. When this value is dropped, the permission is
/// free for another page.
struct PageSlot(Arc<AtomicUsize>);

impl Drop for PageSlot {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Starts the session of a page, and passes messages between the page and the session until one of them has ended.
async fn serve_page(mut socket: WebSocket, shared: ServerState, place: PageSlot) {
    let (ask, asks) = sync_channel(MOST_ASKS);
    let (tells, mut told) = mpsc::channel(UNSENT);
    let session = Session { asks, tells, turn: shared.turn.clone() };
    if start(session, place, &shared.threads).is_err() {
        return;
    }
    let mut stop = shared.stop.clone();
    loop {
        tokio::select! {
            message = told.recv() => {
                let message = match message {
                    Some(PageMessage::Text(text)) => ws::Message::Text(text.into()),
                    Some(PageMessage::Frame(bytes)) => ws::Message::Binary(Bytes::from(bytes)),
                    None => break,
                };
                if socket.send(message).await.is_err() {
                    break;
                }
            }
            message = socket.recv() => match message {
                Some(Ok(message)) => if !hear(&message, &ask) { break },
                _ => break,
            },
            () = until_told(&mut stop) => break,
        }
    }
}

/// Passes a request of a page to the session of this page. Returns false if the connection must be closed, because the
/// request is wrong or too many requests wait.
fn hear(message: &ws::Message, ask: &SyncSender<Ask>) -> bool {
    match message {
        ws::Message::Text(text) => serde_json::from_str(text).is_ok_and(|asked| ask.try_send(asked).is_ok()),
        ws::Message::Binary(_) | ws::Message::Close(_) => false,
        ws::Message::Ping(_) | ws::Message::Pong(_) => true,
    }
}

/// Starts the thread of a session, which runs the panels of one page. All computations of the session run in this
/// thread.
fn start(
    session: Session,
    place: PageSlot,
    threads: &Mutex<Vec<JoinHandle<()>>>,
) -> Result<(), rayon::ThreadPoolBuildError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).spawn_handler(|worker| {
        let thread = std::thread::Builder::new().name("lab engine".into()).spawn(|| worker.run())?;
        let mut threads = threads.lock().unwrap_or_else(PoisonError::into_inner);
        threads.retain(|thread| !thread.is_finished());
        threads.push(thread);
        Ok(())
    });
    // the thread ends when the session has ended and the pool is dropped
    pool.build()?.spawn(move || {
        session.run();
        drop(place);
    });
    Ok(())
}
