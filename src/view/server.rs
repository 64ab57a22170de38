//! Server of a page for this machine alone: it listens on the loopback address, answers GET, and refuses foreign hosts.

use crate::error::{Error, Result};
use std::fmt;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Largest head of a request, bytes.
const MOST: usize = 16 * 1024;
/// Largest number of requests that are answered at once.
const AT_ONCE: usize = 32;
/// Time in which a request has to arrive, from its first byte to its last: a client that sends it byte by byte holds no place for longer.
const REQUEST: Duration = Duration::from_secs(5);
/// Time in which an answer has to be taken: a page of some megabytes through a slow tunnel.
const ANSWER: Duration = Duration::from_secs(60);
/// Time in which a connection to this server is made.
const CONNECT: Duration = Duration::from_secs(5);

/// Reply to a request that is good.
#[derive(Debug)]
pub struct Reply {
    /// Media type.
    pub kind: &'static str,
    /// Content.
    pub body: String,
}

/// Server; it ends when this is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens on 127.0.0.1 and `port`, 0 for any that is free; `answer` gives the content of a path, None where there is none.
    ///
    /// # Errors
    /// Fails if the port is taken or no thread can be started.
    pub fn start(port: u16, answer: impl Fn(&str) -> Option<Reply> + Send + Sync + 'static) -> Result<Self> {
        let cannot = |e: std::io::Error| {
            Error::Argument(format!("cannot listen on 127.0.0.1:{port}: {e}; --port takes another, 0 any that is free"))
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
        // Wakes the thread that waits for the next request.
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
        // A client that has gone needs no answer, and one too many asks again.
        let Ok(stream) = stream else { continue };
        if running.load(Ordering::SeqCst) >= AT_ONCE {
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
        Ok(path) => answer(&path).ok_or(Refusal::NoSuchPath),
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
    // What was sent and not read, as the body of a POST, would break off the answer on its way.
    stream.end = Instant::now() + REQUEST;
    std::io::copy(&mut stream.take(MOST as u64), &mut std::io::sink()).map(|_| ())
}

/// Connection whose reads and writes all end before one time, whatever the number of bytes of each.
struct Timed {
    stream: TcpStream,
    end: Instant,
}

impl Timed {
    /// Returns the time that is left.
    fn left(&self) -> std::io::Result<Option<Duration>> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(std::io::ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for Timed {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(bytes)
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}

/// Reason why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refusal {
    BadRequest,
    ForeignHost,
    NoSuchPath,
    NotGet,
    TooLarge,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Refusal::BadRequest => "400 Bad Request",
            Refusal::ForeignHost => "403 Forbidden",
            Refusal::NoSuchPath => "404 Not Found",
            Refusal::NotGet => "405 Method Not Allowed",
            Refusal::TooLarge => "431 Request Header Fields Too Large",
        })
    }
}

/// Reads the head of a request; returns its path without the query.
fn read(stream: &mut Timed) -> std::io::Result<std::result::Result<String, Refusal>> {
    let (mut head, mut part) = (Vec::new(), [0; 2048]);
    loop {
        let count = stream.read(&mut part)?;
        head.extend_from_slice(&part[..count]);
        match path(&head) {
            Some(path) => return Ok(path),
            None if count == 0 => return Ok(Err(Refusal::BadRequest)),
            None if head.len() > MOST => return Ok(Err(Refusal::TooLarge)),
            None => {}
        }
    }
}

/// Returns the path that a head asks for; None if it is not whole yet.
fn path(head: &[u8]) -> Option<std::result::Result<String, Refusal>> {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        Ok(httparse::Status::Partial) => return None,
        Ok(httparse::Status::Complete(_)) => {}
        Err(httparse::Error::TooManyHeaders) => return Some(Err(Refusal::TooLarge)),
        Err(_) => return Some(Err(Refusal::BadRequest)),
    }
    let mut hosts = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case("host"));
    let host = hosts.next().and_then(|host| std::str::from_utf8(host.value).ok());
    Some(match (host, hosts.next(), request.method, request.path) {
        (Some(host), None, ..) if !is_here(host) => Err(Refusal::ForeignHost),
        (Some(_), None, Some("GET"), Some(path)) => Ok(path.split('?').next().unwrap_or_default().into()),
        (Some(_), None, Some(_), _) => Err(Refusal::NotGet),
        _ => Err(Refusal::BadRequest),
    })
}

/// Returns true for a name of this machine: a page from elsewhere whose name was made to lead here still sends its own. Any port is right,
/// because that of a tunnel is another.
fn is_here(host: &str) -> bool {
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    matches!(name, "127.0.0.1" | "localhost")
}
