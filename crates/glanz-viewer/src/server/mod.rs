//! HTTP and WebSocket: the page, its model, its conversation, its files.
//!
//! [`Server::bind`] opens the port and says the address, [`Server::run`] serves until it is told to stop. Requests come first to `guard`
//! (who is admitted) and end in `headers`; `page` gives out the files of the page, `models` what it draws, `socket` speaks with it, `upload`
//! takes in files that are dropped on it, `watch` reads the scene again when it changes. Everything that visitors can make grow has one of
//! the [`Limits`].

mod address;
mod dress;
mod guard;
mod headers;
mod house;
mod key;
mod leaves;
mod message;
mod models;
mod page;
mod session;
mod settings;
mod shown;
mod socket;
mod upload;
mod watch;

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, Path as UrlPath, Request, State};
use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, HeaderValue, SET_COOKIE};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use glanz_formats::Diagnostics;
use glanz_job::CancelFlag;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

use self::guard::{Admission, Guard};
use self::house::House;
use self::key::Key;

pub use self::dress::Dress;
pub use self::settings::{DEFAULT_PORT, Limits, ServerSettings};
pub use self::shown::Shown;

/// Why there is no server.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// No port can be opened there.
    #[error("{address}: cannot be served from: {source}")]
    Address {
        /// Host and port.
        address: String,
        /// Why.
        source: std::io::Error,
    },
    /// The system gives no threads or timers.
    #[error("the server cannot be started: {0}")]
    Start(#[from] std::io::Error),
    /// The system gives no random numbers.
    #[error("there are no random numbers for a token: {0}")]
    Random(#[from] getrandom::Error),
}

/// What became of a scene whose files changed.
#[derive(Clone, Debug)]
pub enum News {
    /// It was read again, and pages show it.
    Read(Arc<Shown>),
    /// It cannot be read; pages show the old one.
    Refused(Diagnostics),
}

/// Someone who wants to know what becomes of a scene whose files change.
pub type Listener = Box<dyn Fn(&News) + Send + Sync>;

/// A server with an open port.
pub struct Server {
    listener: TcpListener,
    house: Arc<House>,
    address: String,
    watched: Option<PathBuf>,
}

impl Server {
    /// Opens a port for pages that show `shown`, the scene of the file `scene`. `listener` is told when that is read again.
    ///
    /// # Errors
    /// [`ServerError`].
    pub fn bind(
        settings: &ServerSettings,
        scene: &Path,
        shown: Shown,
        listener: Listener,
    ) -> Result<Self, ServerError> {
        let (socket, port) = address::bind(settings.host.as_deref(), settings.port)?;
        let base = address::shown(&socket, settings.host.as_deref())?;
        let (guard, address) = match &settings.host {
            None => (Guard::local(), base),
            Some(host) => {
                let key = Key::random()?;
                (Guard::with_token(host, port, key), format!("{base}?token={key}"))
            }
        };
        let house = House::new(settings, guard, shown, listener)?;
        let watched = settings.watch.then(|| scene.to_owned());
        Ok(Self { listener: socket, house: Arc::new(house), address, watched })
    }

    /// The address of the page, with its token if it needs one.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Serves until `cancel` is raised, then sends all pages away.
    ///
    /// # Errors
    /// [`ServerError::Start`].
    pub fn run(self, cancel: &CancelFlag) -> Result<(), ServerError> {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
        let Self { listener, house, watched, .. } = self;
        runtime.block_on(async {
            listener.set_nonblocking(true)?;
            let listener = tokio::net::TcpListener::from_std(listener)?;
            let serving = tokio::spawn(accept(listener, Arc::clone(&house)));
            let watching = watched.map(|scene| tokio::spawn(watch::watch(Arc::clone(&house), scene)));
            while !cancel.is_cancelled() {
                sleep(STOP_INTERVAL).await;
            }
            serving.abort();
            watching.inspect(tokio::task::JoinHandle::abort);
            house.close().await;
            Ok::<_, std::io::Error>(())
        })?;
        // What is still built then is of no use to anybody.
        runtime.shutdown_timeout(Duration::from_secs(1));
        Ok(())
    }
}

/// Time between two looks whether to stop.
pub(crate) const STOP_INTERVAL: Duration = Duration::from_millis(50);

/// Takes in connections, for ever.
async fn accept(listener: tokio::net::TcpListener, house: Arc<House>) {
    let connections = Arc::new(Semaphore::new(house.limits.connections));
    let limits = house.limits;
    let app = router(house);
    loop {
        let Ok(permit) = Arc::clone(&connections).acquire_owned().await else { return };
        let Ok((stream, _)) = listener.accept().await else {
            // Mostly a lack of file descriptors, which passes.
            sleep(STOP_INTERVAL).await;
            continue;
        };
        // Pages wait for small messages. Where that cannot be set they come a little later.
        let _ = stream.set_nodelay(true);
        let service = TowerToHyperService::new(app.clone());
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(limits.header_time)
            .max_buf_size(MAX_HEADERS)
            .serve_connection(TokioIo::new(stream), service)
            .with_upgrades();
        tokio::spawn(async move {
            let _permit = permit;
            // Whatever goes wrong with a connection ends it, and nothing else.
            let _ = timeout(limits.connection_time, connection).await;
        });
    }
}

/// Bytes of the headers of a request, about.
const MAX_HEADERS: usize = 32 << 10;

/// All that can be asked for.
fn router(house: Arc<House>) -> Router {
    // What is around the files in a request takes some space too.
    let upload = DefaultBodyLimit::max(house.limits.upload_bytes + (house.limits.upload_files << 10));
    Router::new()
        .route("/model/{key}", get(model))
        .route("/ws", get(socket))
        .route("/open", post(upload::open).layer(upload))
        .fallback_service(get(page::serve))
        .layer(from_fn_with_state(Arc::clone(&house), check))
        .with_state(house)
}

/// Lets the guard look at a request, and secures the answer.
async fn check(State(house): State<Arc<House>>, request: Request, next: Next) -> Response {
    let uri = request.uri();
    let mut response = match house.guard.admit(uri.path(), uri.query(), request.headers()) {
        Admission::Granted => next.run(request).await,
        Admission::WithCookie(cookie) => {
            let mut response = next.run(request).await;
            if let Ok(cookie) = HeaderValue::from_str(&cookie) {
                response.headers_mut().insert(SET_COOKIE, cookie);
            }
            response
        }
        Admission::Refused(status, reason) => (status, reason).into_response(),
    };
    headers::secure(response.headers_mut());
    response
}

async fn model(State(house): State<Arc<House>>, UrlPath(key): UrlPath<String>) -> Response {
    match Key::parse(&key).and_then(|key| house.models.get(&key)) {
        Some(bytes) => ([(CONTENT_TYPE, "application/octet-stream")], bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such model any more").into_response(),
    }
}

async fn socket(State(house): State<Arc<House>>, upgrade: WebSocketUpgrade) -> Response {
    let Some(seat) = house.sessions.join(house.posted()) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "there are too many pages").into_response();
    };
    let bytes = house.limits.message_bytes;
    upgrade
        .max_message_size(bytes)
        .max_frame_size(bytes)
        .on_upgrade(move |socket| socket::converse(house, seat, socket))
}
