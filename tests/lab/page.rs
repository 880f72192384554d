//! Page of the lab for tests: plain requests, and a WebSocket. The server cannot distinguish it from a real page.

use diptych::lab::LabServer;
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// Longest waiting time for an event that must occur. It is long because the machine may be busy.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Time without messages after which a test assumes that no message will come.
pub const SILENCE: Duration = Duration::from_millis(600);

/// Status of the answer to a plain request, and its whole text.
pub fn get(address: SocketAddr, path: &str, headers: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    (text.split(' ').nth(1).unwrap().parse().unwrap(), text)
}

pub fn path_of(lab: &LabServer) -> String {
    lab.url().split(&lab.address().to_string()).nth(1).unwrap().to_owned()
}

/// Page of the lab for tests.
pub struct Page {
    pub socket: WebSocket<TcpStream>,
    pub serial: u32,
}

/// Message that a page has received.
pub enum Sent {
    Told(Value),
    Framed(Value, Vec<f32>),
    Nothing,
}

impl Page {
    pub fn open(address: SocketAddr, path: &str, origin: Option<&str>) -> Result<Self, u16> {
        let mut request = format!("ws://{address}{path}socket").into_client_request().unwrap();
        if let Some(origin) = origin {
            request.headers_mut().insert("origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Self { socket, serial: 0 }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }

    pub fn of(lab: &LabServer) -> Self {
        let page = Self::open(lab.address(), &path_of(lab), Some(&format!("http://{}", lab.address())));
        page.unwrap_or_else(|status| panic!("refused with {status}"))
    }

    pub fn ask(&mut self, ask: Value) {
        self.socket.send(Message::Text(ask.to_string().into())).unwrap();
    }

    pub fn choose(&mut self, scene: &str, settings: Value, right: usize) {
        self.serial += 1;
        self.ask(json!({"ask": "open", "scene": scene, "settings": settings, "right": right, "serial": self.serial}));
    }

    pub fn next(&mut self, patience: Duration) -> Sent {
        self.socket.get_mut().set_read_timeout(Some(patience)).unwrap();
        match self.socket.read() {
            Ok(Message::Text(text)) => Sent::Told(serde_json::from_str(&text).unwrap()),
            Ok(Message::Binary(bytes)) => {
                let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
                let head = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
                let values = bytes[4 + length..].chunks(4).map(|four| f32::from_le_bytes(four.try_into().unwrap()));
                Sent::Framed(head, values.collect())
            }
            _ => Sent::Nothing,
        }
    }

    /// Next message to the page, except frames.
    pub fn told(&mut self) -> Value {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            match self.next(PATIENCE) {
                Sent::Told(value) => return value,
                Sent::Framed(..) => self.ask(json!({"ask": "drawn"})),
                Sent::Nothing => break,
            }
        }
        panic!("nothing was told");
    }

    /// Next frame of the scene that was chosen last. The page reports the frame as drawn.
    pub fn frame(&mut self) -> (Value, Vec<f32>) {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            if let Sent::Framed(head, values) = self.next(PATIENCE) {
                self.ask(json!({"ask": "drawn"}));
                if head["serial"] == self.serial {
                    return (head, values);
                }
            }
        }
        panic!("no frame came");
    }
}
