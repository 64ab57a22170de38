//! HTTP server for this machine only: it listens on the loopback address, answers GET, and rejects foreign hosts.

use base::error::{Error, Result};
use std::fmt;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Maximum size of a request head, bytes.
const MAX_REQUEST_SIZE: usize = 16 * 1024;
/// Maximum number of concurrent requests.
const MAX_CONCURRENT: usize = 32;
/// Timeout for the whole request, so that a slow client does not occupy a thread for longer.
const REQUEST: Duration = Duration::from_secs(5);
/// Timeout for the whole answer, long enough for a page of some megabytes through a slow tunnel.
const ANSWER: Duration = Duration::from_secs(60);
/// Timeout of a connection to this server.
const CONNECT: Duration = Duration::from_secs(5);

/// Reply to a valid request.
#[derive(Debug)]
pub struct Reply {
    /// Media type.
    pub kind: &'static str,
    /// Content.
    pub body: String,
}

/// Server; it stops when dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens on 127.0.0.1 and `port`, 0 for a free port; `answer` returns the content of a path, None if there is
    /// none.
    ///
    /// # Errors
    /// Fails if the port is in use or no thread can be started.
    pub fn start(port: u16, answer: impl Fn(&str) -> Option<Reply> + Send + Sync + 'static) -> Result<Self> {
        let cannot = |e: std::io::Error| {
            Error::Argument(format!(
                "cannot listen on 127.0.0.1:{port}: {e}; --port selects another port, 0 any free one"
            ))
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(cannot)?;
        let address = listener.local_addr().map_err(cannot)?;
        let ended = Arc::new(AtomicBool::new(false));
        let over = ended.clone();
        let listen = move || accept(&listener, &over, &Arc::new(answer));
        let thread = std::thread::Builder::new().name("viewer".into()).spawn(listen).map_err(cannot)?;
        Ok(Self { address, ended, thread: Some(thread) })
    }

    /// Returns address and port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::SeqCst);
        // A connection wakes the thread that waits for requests.
        if TcpStream::connect_timeout(&self.address, CONNECT).is_ok()
            && let Some(thread) = self.thread.take()
        {
            let _ = thread.join();
        }
    }
}

fn accept<F>(listener: &TcpListener, ended: &AtomicBool, answer: &Arc<F>)
where
    F: Fn(&str) -> Option<Reply> + Send + Sync + 'static,
{
    let running = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        if ended.load(Ordering::SeqCst) {
            return;
        }
        // Closed connections and those beyond the limit are dropped; the page retries.
        let Ok(stream) = stream else { continue };
        if running.load(Ordering::SeqCst) >= MAX_CONCURRENT {
            continue;
        }
        running.fetch_add(1, Ordering::SeqCst);
        let (answer, own) = (answer.clone(), running.clone());
        let serve = move || {
            let _ = serve(stream, answer.as_ref());
            own.fetch_sub(1, Ordering::SeqCst);
        };
        if std::thread::Builder::new().name("viewer request".into()).spawn(serve).is_err() {
            running.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

/// Answers one request and closes the connection.
fn serve(stream: TcpStream, answer: &dyn Fn(&str) -> Option<Reply>) -> std::io::Result<()> {
    let mut stream = Timed { stream, end: Instant::now() + REQUEST };
    let reply = match read(&mut stream)? {
        Ok(path) => answer(&path).ok_or(RequestError::NoSuchPath),
        Err(refusal) => Err(refusal),
    };
    let (status, kind, body) = match reply {
        Ok(Reply { kind, body }) => ("200 OK".into(), kind, body),
        Err(refusal) => (refusal.to_string(), "text/plain; charset=utf-8", format!("{refusal}\n")),
    };
    let allow = if status.starts_with("405") { "Allow: GET\r\n" } else { "" };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{allow}Cache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Referrer-Policy: no-referrer\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.end = Instant::now() + ANSWER;
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.stream.shutdown(Shutdown::Write)?;
    // Reads the rest of the request, e.g. the body of a POST: closing a socket with unread data would abort the answer.
    stream.end = Instant::now() + REQUEST;
    std::io::copy(&mut stream.take(MAX_REQUEST_SIZE as u64), &mut std::io::sink()).map(|_| ())
}

/// Connection with one deadline for all reads and writes.
struct Timed {
    stream: TcpStream,
    end: Instant,
}

impl Timed {
    /// Returns the remaining time; an error after the deadline.
    fn remaining(&self) -> std::io::Result<Option<Duration>> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(std::io::ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for Timed {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.stream.set_read_timeout(self.remaining()?)?;
        self.stream.read(bytes)
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.stream.set_write_timeout(self.remaining()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}

/// Reason for rejecting a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RequestError {
    BadRequest,
    ForeignHost,
    NoSuchPath,
    NotGet,
    TooLarge,
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RequestError::BadRequest => "400 Bad Request",
            RequestError::ForeignHost => "403 Forbidden",
            RequestError::NoSuchPath => "404 Not Found",
            RequestError::NotGet => "405 Method Not Allowed",
            RequestError::TooLarge => "431 Request Header Fields Too Large",
        })
    }
}

/// Reads the head of a request; returns its path without the query.
fn read(stream: &mut Timed) -> std::io::Result<std::result::Result<String, RequestError>> {
    let (mut head, mut part) = (Vec::new(), [0; 2048]);
    loop {
        let count = stream.read(&mut part)?;
        head.extend_from_slice(&part[..count]);
        match path(&head) {
            Some(path) => return Ok(path),
            None if count == 0 => return Ok(Err(RequestError::BadRequest)),
            None if head.len() > MAX_REQUEST_SIZE => return Ok(Err(RequestError::TooLarge)),
            None => {}
        }
    }
}

/// Returns the path of a request head; None if the head is incomplete.
fn path(head: &[u8]) -> Option<std::result::Result<String, RequestError>> {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        Ok(httparse::Status::Partial) => return None,
        Ok(httparse::Status::Complete(_)) => {}
        Err(httparse::Error::TooManyHeaders) => return Some(Err(RequestError::TooLarge)),
        Err(_) => return Some(Err(RequestError::BadRequest)),
    }
    let mut hosts = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case("host"));
    let host = hosts.next().and_then(|host| std::str::from_utf8(host.value).ok());
    Some(match (host, hosts.next(), request.method, request.path) {
        (Some(host), None, ..) if !is_local_host(host) => Err(RequestError::ForeignHost),
        (Some(_), None, Some("GET"), Some(path)) => Ok(path.split('?').next().unwrap_or_default().into()),
        (Some(_), None, Some(_), _) => Err(RequestError::NotGet),
        _ => Err(RequestError::BadRequest),
    })
}

/// Returns true if `host` is a name of this machine. This prevents DNS rebinding: a foreign page whose name resolves to
/// this address sends its own name. Any port is accepted, because a tunnel has another port.
fn is_local_host(host: &str) -> bool {
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    matches!(name, "127.0.0.1" | "localhost")
}
