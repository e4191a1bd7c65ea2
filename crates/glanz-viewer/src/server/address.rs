//! Address of the server.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, UdpSocket};

use super::ServerError;
use super::settings::DEFAULT_PORT;

/// Opens a port at `host`, or at the loopback address, and returns its number.
///
/// # Errors
/// [`ServerError::Address`] if the port cannot be opened.
pub(crate) fn bind(host: Option<&str>, port: Option<u16>) -> Result<(TcpListener, u16), ServerError> {
    let open = |port: u16| match host {
        None => TcpListener::bind((Ipv4Addr::LOCALHOST, port)),
        Some(host) => TcpListener::bind((host.trim_matches(['[', ']']), port)),
    };
    let opened = match port {
        Some(port) => open(port),
        None => open(DEFAULT_PORT).or_else(|_| open(0)),
    };
    let refused = |source: io::Error| {
        let host = host.unwrap_or("127.0.0.1");
        let address = port.map_or_else(|| host.to_owned(), |port| format!("{host}:{port}"));
        ServerError::Address { address, source }
    };
    let listener = opened.map_err(refused)?;
    let port = listener.local_addr()?.port();
    Ok((listener, port))
}

/// The URL of the page.
///
/// # Errors
/// [`ServerError::Start`] if the system does not know it.
pub(crate) fn page_url(listener: &TcpListener, host: Option<&str>) -> Result<String, ServerError> {
    let local = listener.local_addr()?;
    Ok(match host.filter(|host| host.trim_matches(['[', ']']).parse::<IpAddr>().is_err()) {
        Some(name) => format!("http://{name}:{}/", local.port()),
        // All addresses of the machine: the one by which others are likely to reach it.
        None if local.ip().is_unspecified() => {
            format!("http://{}/", SocketAddr::new(outward(local.ip()).unwrap_or(local.ip()), local.port()))
        }
        None => format!("http://{local}/"),
    })
}

/// The address from which this machine would send to a remote host; nothing is sent. The remote addresses are reserved for documentation
/// (RFC 5737, RFC 3849).
fn outward(any: IpAddr) -> Option<IpAddr> {
    let far: IpAddr = match any {
        IpAddr::V4(_) => Ipv4Addr::new(192, 0, 2, 1).into(),
        IpAddr::V6(_) => Ipv6Addr::new(0x2001, 0xdb8, 0, 0, 0, 0, 0, 1).into(),
    };
    let socket = UdpSocket::bind((any, 0)).ok()?;
    socket.connect((far, 9)).ok()?;
    socket.local_addr().ok().map(|address| address.ip())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_taken_is_an_error_only_if_it_was_asked_for() {
        let (first, port) = bind(None, Some(0)).unwrap();
        assert_ne!(port, 0);
        assert!(matches!(bind(None, Some(port)), Err(ServerError::Address { .. })));
        assert_eq!(page_url(&first, None).unwrap(), format!("http://127.0.0.1:{port}/"));
        // A port is found whether or not the usual one is free.
        assert!(bind(None, None).is_ok());
    }

    #[test]
    fn addresses_are_those_that_a_browser_takes() {
        let (listener, port) = bind(Some("127.0.0.1"), Some(0)).unwrap();
        assert_eq!(page_url(&listener, Some("127.0.0.1")).unwrap(), format!("http://127.0.0.1:{port}/"));
        assert_eq!(page_url(&listener, Some("localhost")).unwrap(), format!("http://localhost:{port}/"));
        let (everywhere, port) = bind(Some("0.0.0.0"), Some(0)).unwrap();
        assert!(page_url(&everywhere, Some("0.0.0.0")).unwrap().ends_with(&format!(":{port}/")));
    }
}
