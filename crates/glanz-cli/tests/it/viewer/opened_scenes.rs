//! The processes of scenes that pages have opened.
#![cfg(target_os = "linux")]

use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use super::server::{ViewServer, entries, serve_in, temporary_folder};
use super::soak::process::{Usage, children};
use super::soak::visitor::Visitor;
use super::upload::{BALL, endless_includes, open, request, text_file};
use crate::command_line::support::wait_within;

/// Longer than anything takes on a busy machine, but shorter than the time limit of reading, which ends every process.
const PATIENCE: Duration = Duration::from_secs(20);

fn until(what: &str, is_so: impl Fn() -> bool) {
    wait_within(PATIENCE, what, is_so);
}

fn kill(process: u32) {
    assert!(Command::new("kill").args(["-9", &process.to_string()]).status().unwrap().success());
}

/// Opens a ball on the page, and returns the process of its scene.
fn open_ball(served: &ViewServer, page: &mut Visitor) -> u32 {
    let others = children(served.id());
    let answer = open(&served.host, &page.session, &[text_file("ball.pbrt", BALL)]).unwrap();
    assert_eq!(answer.status, 200, "{}", String::from_utf8_lossy(&answer.body));
    let scene = page.await_text("the scene", |message| message["name"] == "ball.pbrt").unwrap();
    assert!(scene["error"].is_null());
    let new =
        children(served.id()).into_iter().filter(|process| !others.contains(process)).collect::<Vec<_>>();
    let [process] = new.as_slice() else { panic!("{new:?}") };
    *process
}

#[test]
fn abandoned_uploads_leave_nothing_behind() {
    let temporary = temporary_folder();
    let served = serve_in(&temporary);
    let upload = |page: &Visitor| {
        let mut stream = TcpStream::connect(&served.host).unwrap();
        stream.write_all(&request(&served.host, &page.session, &endless_includes())).unwrap();
        stream
    };
    // Four at a time, all of which leave at once.
    let four = || {
        let pages: Vec<Visitor> = (0..4).map(|_| Visitor::try_new(&served.host).unwrap()).collect();
        let streams: Vec<TcpStream> = pages.iter().map(upload).collect();
        until("four processes", || children(served.id()).len() == 4);
        drop((streams, pages));
        until("the end of all processes", || children(served.id()).is_empty());
    };
    // Afterwards all threads of the server run, and its memory is that of its largest number of uploads. Connections end a moment later.
    four();
    std::thread::sleep(Duration::from_millis(500));
    let before = Usage::of(served.id()).unwrap();
    // One after the other, of which four would be the most at a time: permits come back when a process has ended.
    for number in 0..6 {
        let page = Visitor::try_new(&served.host).unwrap();
        let stream = upload(&page);
        until("a process", || children(served.id()).len() == 1);
        if number % 2 == 0 {
            // The upload is abandoned, or else the page leaves.
            drop(stream);
            until("the end of a process", || children(served.id()).is_empty());
        } else {
            drop(page);
            until("the end of a process", || children(served.id()).is_empty());
        }
    }
    four();
    four();
    until("an empty folder", || entries(&temporary) == 0);
    let after = Usage::settled(served.id(), before, PATIENCE).unwrap();
    println!("before: {before}; after 14 abandoned uploads: {after}");
    assert!(after.threads <= before.threads && after.files <= before.files, "{before} {after}");
    assert!(after.memory < before.memory + 16.0, "{before} {after}");
    let mut page = Visitor::try_new(&served.host).unwrap();
    open_ball(&served, &mut page);
}

#[test]
fn process_of_an_opened_scene_is_confined() {
    let temporary = temporary_folder();
    let served = serve_in(&temporary);
    let mut page = Visitor::try_new(&served.host).unwrap();
    let process = open_ball(&served, &mut page);
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let value = |name: &str| status.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
    match value("Seccomp:") {
        Some(mode) => assert_eq!((mode, value("NoNewPrivs:")), ("2", Some("1"))),
        None => println!("this system has no seccomp"),
    }
    let limits = std::fs::read_to_string(format!("/proc/{process}/limits")).unwrap();
    for (name, most) in [("Max open files", 256), ("Max core file size", 0)] {
        let line = limits.lines().find_map(|line| line.strip_prefix(name)).unwrap();
        let values: Vec<u64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        assert!(values.len() == 2 && values.iter().all(|value| *value <= most), "{name}{line}");
    }
}

#[test]
fn page_is_told_that_the_process_of_its_scene_was_killed() {
    let temporary = temporary_folder();
    let mut served = serve_in(&temporary);
    let [mut page, mut other] = [(); 2].map(|()| Visitor::try_new(&served.host).unwrap());
    let processes = [&mut page, &mut other].map(|page| open_ball(&served, page));
    page.pick().unwrap();
    kill(processes[0]);
    let scene = page.await_text("an error", |message| message["type"] == "scene").unwrap();
    assert!(scene["model"].is_null());
    let sentence = "the program that reads the scene stopped unexpectedly; open the file again";
    assert_eq!((scene["name"].as_str(), scene["error"].as_str()), (Some("ball.pbrt"), Some(sentence)));
    // Nothing of it is left, and requests fail with the sentence.
    assert_eq!((children(served.id()), entries(&temporary)), (vec![processes[1]], 1));
    assert!(page.pick().unwrap_err().contains(sentence));
    other.pick().unwrap();
    assert!(served.is_alive());
    let again = open_ball(&served, &mut page);
    page.pick().unwrap();
    assert!(again != processes[0]);
    // A process that is stopped does not notice that the page leaves, and is ended all the same.
    assert!(Command::new("kill").args(["-STOP", &again.to_string()]).status().unwrap().success());
    drop((page, other));
    until("the end of all processes", || children(served.id()).is_empty());
    until("an empty folder", || entries(&temporary) == 0);
}

#[test]
fn processes_end_with_the_server_and_the_next_one_removes_their_files() {
    let temporary = temporary_folder();
    let served = serve_in(&temporary);
    let mut page = Visitor::try_new(&served.host).unwrap();
    let process = open_ball(&served, &mut page);
    let reading = Visitor::try_new(&served.host).unwrap();
    let mut stream = TcpStream::connect(&served.host).unwrap();
    stream.write_all(&request(&served.host, &reading.session, &endless_includes())).unwrap();
    until("a process", || children(served.id()).len() == 2);
    let processes = children(served.id());
    assert!(processes.contains(&process));
    kill(served.id());
    let is_there = |process: &u32| Path::new(&format!("/proc/{process}/exe")).exists();
    until("the end of all processes", || !processes.iter().any(is_there));
    assert_eq!(entries(&temporary), 2);
    drop(served);
    let next = serve_in(&temporary);
    assert_eq!(entries(&temporary), 0);
    // One that ends on request removes them itself.
    let mut page = Visitor::try_new(&next.host).unwrap();
    let process = open_ball(&next, &mut page);
    assert!(Command::new("kill").args(["-INT", &next.id().to_string()]).status().unwrap().success());
    until("the end of all processes", || !is_there(&process));
    until("an empty folder", || entries(&temporary) == 0);
}
