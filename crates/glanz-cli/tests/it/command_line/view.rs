//! `glanz view`: the printed address and the end of the process.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Command;

use crate::command_line::support::{Folder, finish};

#[test]
fn the_address_is_printed_and_a_signal_ends_the_server() {
    let folder = Folder::with_scene();
    let line = "view small.pbrt --no-open --port 0";
    let mut child = folder.start(line);
    let mut address = String::new();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    output.read_line(&mut address).unwrap();
    let host = address.trim().strip_prefix("http://").and_then(|a| a.strip_suffix('/')).unwrap().to_owned();
    let mut stream = TcpStream::connect(&host).unwrap();
    write!(stream, "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    let ran = finish(child, line);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(TcpStream::connect(&host).is_err());
}

#[test]
fn unusable_scenes_and_addresses_are_refused() {
    let folder = Folder::with_scene();
    folder.write("bad.pbrt", "WorldBegin\nShape\n");
    folder.run("view bad.pbrt --no-open --port 0").refused(1, &["bad.pbrt:2:1: ", "needs a name"]);
    folder.run("view none.pbrt --no-open --port 0").refused(1, &["none.pbrt: the file cannot be read"]);
    let nowhere = folder.run("view small.pbrt --no-open --host 192.0.2.1 --port 0");
    nowhere.refused(1, &["192.0.2.1:0: the server cannot listen on this address", "help: "]);
}
