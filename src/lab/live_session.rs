//! Sends the frames of a live view (data of one instant each, from which the page draws) to one page.

use super::live::{FRAME, LiveFeed};
use super::protocol::Ask;
use super::server::until_told;
use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket};
use std::sync::atomic::Ordering;
use tokio::sync::watch;

/// Largest number of frames (data of one instant each) that have been sent to the page, but that the page has not
/// drawn.
const UNDRAWN: u32 = 2;

/// Sends frames (data of one instant each) until the page is closed or the server stops. A page that is still open when
/// the run ends gets the final frame.
pub async fn serve_live(mut socket: WebSocket, feed: &LiveFeed, mut stop: watch::Receiver<bool>) {
    if socket.send(Message::Text(feed.opened.clone().into())).await.is_err() {
        return;
    }
    feed.pages.fetch_add(1, Ordering::Relaxed);
    let (mut sent, mut undrawn) = (0, 0);
    loop {
        let is_over = tokio::select! {
            () = tokio::time::sleep(FRAME) => false,
            () = until_told(&mut stop) => true,
            message = socket.recv() => match message {
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                Some(Ok(Message::Text(text))) if matches!(serde_json::from_str(&text), Ok(Ask::Drawn)) => {
                    undrawn = u32::saturating_sub(undrawn, 1);
                    continue;
                }
                _ => break,
            },
        };
        let (number, frame) = feed.latest();
        if number > sent && (undrawn < UNDRAWN || is_over) {
            if socket.send(Message::Binary(Bytes::copy_from_slice(&frame))).await.is_err() {
                break;
            }
            (sent, undrawn) = (number, undrawn + 1);
        }
        if is_over {
            // the page continues to show the final frame when the connection ends
            let _ = socket.send(Message::Close(None)).await;
            break;
        }
    }
    feed.pages.fetch_sub(1, Ordering::Relaxed);
}
