//! Uploads that demand more than a page may have, lie about what they are, or never end.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::Dice;
use super::visitor::{Fault, Visitor};
use crate::viewer::http::{self, PATIENCE};
use crate::viewer::upload::{BALL, UploadedFile, endless_includes, head, request, text_file};

/// A kind of upload: its name, and the function that performs it on a page that has just connected, and returns whether the server admitted it.
type HostileUpload = (&'static str, fn(&str, Visitor, &mut Dice) -> Result<bool, Fault>);

/// Time after which a page no longer waits for others to have opened their files.
const WAIT: Duration = Duration::from_secs(120);

/// Time within which a server refuses an upload that it does not admit.
const REFUSAL: Duration = Duration::from_millis(200);

/// Response of a server with too many uploads, or too many opened scenes.
const BUSY: u16 = 503;

/// Response to files that are no scene, or beyond the limits.
const UNREADABLE: u16 = 422;

/// Response to what is no upload, or that of a page that counts as disconnected: while it waits for others it answers no pings.
const BAD: u16 = 400;

/// All kinds.
pub(crate) const ALL: [HostileUpload; 12] = [
    ("includes without end, abandoned", abandoned_includes),
    ("includes without end, whose page leaves", left_includes),
    ("shapes without end", endless_shapes),
    ("a picture that unpacks to a hundred times its size", png_bomb),
    ("a picture that declares more than the memory of a scene", exr_bomb),
    ("a file that is cut off", truncated_file),
    ("a file with random bytes", damaged_file),
    ("names that lead out", traversal),
    ("sizes beyond all limits", huge_sizes),
    ("bytes that come slowly", slow_bytes),
    ("bytes that stop coming", missing_bytes),
    ("a scene that is left while it is rendered", left_rendering),
];

const TEXTURED: &str = "LookAt 0 -4 0  0 0 0  0 0 1\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n\
    Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"FILE\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"\n";

/// Small files of formats that pages open.
const SMALL: [(&str, &str); 7] = [
    ("a.pbrt", BALL),
    (
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    ),
    ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    (
        "a.stl",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
    ),
    ("a.rib", "##RenderMan RIB\nWorldBegin\nSphere 1 -1 1 360\nWorldEnd\n"),
    (
        "a.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\
         \"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36}]}",
    ),
    ("a.step", include_str!("../../../../../glanz-viewer/tests/discs.step")),
];

/// Uploads files in one of the ways on a page of its own. Returns whether the server admitted them.
///
/// # Errors
/// A page that cannot connect, or an upload without an answer.
pub(crate) fn upload(host: &str, kind: usize, dice: &mut Dice) -> Result<bool, Fault> {
    let (name, does) = ALL[kind % ALL.len()];
    let page = Visitor::try_new(host)?;
    does(host, page, dice).map_err(|fault| format!("{name}: {fault}"))
}

/// Sends bytes, and those again that are refused because too many pages are opening files.
fn send(host: &str, bytes: &[u8]) -> Result<http::Answer, Fault> {
    let start = Instant::now();
    loop {
        let answer = http::send(host, bytes).map_err(|error| error.to_string())?;
        if answer.status != BUSY || start.elapsed() > WAIT {
            return Ok(answer);
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Whether the server has begun to serve an upload: neither were there too many, nor counts its page as disconnected.
fn is_admitted(answer: &http::Answer) -> bool {
    answer.status != BUSY && !answer.body.starts_with(b"?session=")
}

fn open(host: &str, page: &Visitor, files: &[UploadedFile]) -> Result<bool, Fault> {
    send(host, &request(host, &page.session, files)).map(|answer| is_admitted(&answer))
}

/// Starts an upload, again while too many pages are opening files, and leaves its answer. Returns whether the server admitted it, too.
fn start(host: &str, bytes: &[u8]) -> Result<(TcpStream, bool), Fault> {
    let start = Instant::now();
    loop {
        let mut stream = TcpStream::connect(host).map_err(|error| error.to_string())?;
        // The server may refuse it before all has arrived.
        let _ = stream.write_all(bytes);
        stream.set_read_timeout(Some(REFUSAL)).map_err(|error| error.to_string())?;
        let mut head = [0; 12];
        // Nothing comes of an upload that is being served.
        let count = stream.peek(&mut head).unwrap_or(0);
        let head = &head[..count];
        if head != b"HTTP/1.1 503" || start.elapsed() > WAIT {
            let is_refused = head == b"HTTP/1.1 503" || head == b"HTTP/1.1 400";
            return Ok((stream, !is_refused));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn pause(dice: &mut Dice) {
    std::thread::sleep(Duration::from_millis(dice.throw(500)));
}

fn abandoned_includes(host: &str, page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let (stream, is_admitted) = start(host, &request(host, &page.session, &endless_includes()))?;
    pause(dice);
    drop(stream);
    // Some pages stay.
    pause(dice);
    drop(page);
    Ok(is_admitted)
}

fn left_includes(host: &str, page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let (mut stream, is_admitted) = start(host, &request(host, &page.session, &endless_includes()))?;
    pause(dice);
    drop(page);
    stream.set_read_timeout(Some(PATIENCE)).map_err(|error| error.to_string())?;
    let mut answer = Vec::new();
    stream
        .read_to_end(&mut answer)
        .map_err(|error| format!("the upload of a page that has left: {error}"))?;
    Ok(is_admitted)
}

fn endless_shapes(host: &str, page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let mut files = endless_includes();
    files.pop();
    files.push(text_file("30.pbrt", "Shape \"sphere\"\n"));
    let (stream, is_admitted) = start(host, &request(host, &page.session, &files))?;
    pause(dice);
    pause(dice);
    drop(stream);
    Ok(is_admitted)
}

fn png_bomb(host: &str, page: Visitor, _: &mut Dice) -> Result<bool, Fault> {
    let scene = TEXTURED.replace("FILE", "bomb.png");
    open(host, &page, &[text_file("a.pbrt", &scene), ("bomb.png".to_owned(), black_png(8192))])
}

fn exr_bomb(host: &str, page: Visitor, _: &mut Dice) -> Result<bool, Fault> {
    let scene = TEXTURED.replace("FILE", "bomb.exr");
    let files = [text_file("a.pbrt", &scene), ("bomb.exr".to_owned(), empty_exr(40_000, DWAA))];
    let answer = send(host, &request(host, &page.session, &files))?;
    match answer.status {
        UNREADABLE | BAD | BUSY => Ok(is_admitted(&answer)),
        _ => Err(answer.head),
    }
}

fn truncated_file(host: &str, page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let (name, text) = SMALL[dice.throw(SMALL.len() as u64) as usize];
    let bytes = text.as_bytes()[..dice.throw(text.len() as u64) as usize].to_vec();
    open(host, &page, &[(name.to_owned(), bytes)])
}

fn damaged_file(host: &str, page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let (name, text) = SMALL[dice.throw(SMALL.len() as u64) as usize];
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..1 + dice.throw(8) {
        let at = dice.throw(bytes.len() as u64) as usize;
        bytes[at] = dice.throw(256) as u8;
    }
    open(host, &page, &[(name.to_owned(), bytes)])
}

fn traversal(host: &str, page: Visitor, _: &mut Dice) -> Result<bool, Fault> {
    for name in ["../a.pbrt", "/tmp/a.pbrt", "a/../../a.pbrt", "..\\a.pbrt", "a\u{0}.pbrt", "."] {
        let answer = send(host, &request(host, &page.session, &[text_file(name, BALL)]))?;
        if ![BAD, BUSY].contains(&answer.status) {
            return Err(format!("{name:?}: {}", answer.head));
        }
    }
    let scene =
        "WorldBegin\nInclude \"../model\"\nInclude \"../task.json\"\nInclude \"/proc/self/environ\"\n";
    let answer = send(host, &request(host, &page.session, &[text_file("a.pbrt", scene)]))?;
    match answer.status {
        UNREADABLE | BAD | BUSY => Ok(is_admitted(&answer)),
        _ => Err(format!("files outside: {}", answer.head)),
    }
}

fn huge_sizes(host: &str, page: Visitor, _: &mut Dice) -> Result<bool, Fault> {
    let mut are_admitted = true;
    for size in ["18446744073709551615", "1000000000000", "67108865"] {
        let body = format!("[[\"a.pbrt\",{size}]]\n{BALL}");
        let bytes = [head(host, &page.session, 1 << 40).into_bytes(), body.into_bytes()].concat();
        let answer = send(host, &bytes)?;
        if ![0, 413, BAD, BUSY].contains(&answer.status) {
            return Err(format!("{size} bytes: {}", answer.head));
        }
        are_admitted &= is_admitted(&answer);
    }
    Ok(are_admitted)
}

fn slow_bytes(host: &str, page: Visitor, _: &mut Dice) -> Result<bool, Fault> {
    let bytes = request(host, &page.session, &[text_file("a.pbrt", BALL)]);
    let (quick, slow) = bytes.split_at(bytes.len() - 50);
    let (mut stream, is_admitted) = start(host, quick)?;
    for byte in &slow[..40] {
        if stream.write_all(&[*byte]).is_err() {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Ok(is_admitted)
}

fn missing_bytes(host: &str, page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let bytes = request(host, &page.session, &endless_includes());
    let (stream, is_admitted) = start(host, &bytes[..dice.throw(bytes.len() as u64) as usize])?;
    pause(dice);
    drop(stream);
    Ok(is_admitted)
}

fn left_rendering(host: &str, mut page: Visitor, dice: &mut Dice) -> Result<bool, Fault> {
    let answer = send(host, &request(host, &page.session, &[text_file("a.pbrt", BALL)]))?;
    match answer.status {
        BAD | BUSY => return Ok(false),
        200 => {}
        _ => return Err(answer.head),
    }
    page.await_text("the scene", |message| message["name"] == "a.pbrt")?;
    let view = page.view([200, 150], 0.0)?;
    page.await_tile(view)?;
    if dice.throw(2) == 0 {
        page.pick()?;
        page.stop(view)?;
    }
    Ok(true)
}

/// A black square as PNG, about 1/158 of its size.
fn black_png(side: u32) -> Vec<u8> {
    let zeros = u64::from(side) * (u64::from(side) + 1);
    let mut header = side.to_be_bytes().repeat(2);
    // Eight bits of grey.
    header.extend([8, 0, 0, 0, 0]);
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, bytes) in [(b"IHDR", header), (b"IDAT", zlib_zeros(zeros)), (b"IEND", vec![])] {
        png.extend((bytes.len() as u32).to_be_bytes());
        let chunk = [&kind[..], &bytes].concat();
        png.extend(&chunk);
        png.extend(crc32(&chunk).to_be_bytes());
    }
    png
}

/// Zeros, compressed (RFC 1950, 1951) by the fixed code: a zero, then copies of 258 bytes from a distance of 1.
fn zlib_zeros(count: u64) -> Vec<u8> {
    let (mut bytes, mut word, mut bits) = (vec![0x78, 0x01], 0_u64, 0);
    // The first bit of `code` is its highest one.
    let mut put = |code: u64, length: u32| {
        word |= (code.reverse_bits() >> (64 - length)) << bits;
        bits += length;
        while bits >= 8 {
            bytes.push(word as u8);
            word >>= 8;
            bits -= 8;
        }
    };
    // The last block, of kind 1 (lowest bit first).
    put(0b1, 1);
    put(0b10, 2);
    let (copies, zeros) = ((count - 1) / 258, (count - 1) % 258 + 1);
    (0..zeros).for_each(|_| put(0b0011_0000, 8));
    for _ in 0..copies {
        put(0b1100_0101, 8);
        put(0, 5);
    }
    put(0, 7);
    put(0, 7);
    // Adler-32 of zeros: the first sum stays 1.
    bytes.extend((((count % 65_521) as u32) << 16 | 1).to_be_bytes());
    bytes
}

/// The checksum of PNG (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    })
}

/// Numbers of compressions of OpenEXR; a block of the lossy one can be very small.
const UNCOMPRESSED: u8 = 0;
const DWAA: u8 = 8;

/// An OpenEXR file with one channel of floats that declares a square and has 20 kB of zeros for it.
fn empty_exr(side: i32, compression: u8) -> Vec<u8> {
    let window: Vec<u8> = [0, 0, side - 1, side - 1].iter().flat_map(|n: &i32| n.to_le_bytes()).collect();
    let channels = [&b"Y\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0"[..], b"\0"].concat();
    let attributes: [(&str, &str, &[u8]); 8] = [
        ("channels", "chlist", &channels),
        ("compression", "compression", &[compression]),
        ("dataWindow", "box2i", &window),
        ("displayWindow", "box2i", &window),
        ("lineOrder", "lineOrder", &[0]),
        ("pixelAspectRatio", "float", &1_f32.to_le_bytes()),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &1_f32.to_le_bytes()),
    ];
    let mut exr = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
    for (name, kind, value) in attributes {
        exr.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        exr.extend((value.len() as u32).to_le_bytes());
        exr.extend(value);
    }
    exr.resize(exr.len() + 20_000, 0);
    exr
}

#[test]
fn bombs_are_files_of_their_formats() {
    use glanz::formats::image;
    use std::path::Path;
    // A small one is read: what a large one unpacks to is what it says.
    let picture = image::read(&black_png(300), Some(Path::new("a.png")), image::Encoding::Srgb).unwrap();
    let colors = picture.pixels.to_rgb().unwrap();
    assert!(colors.len() == 90_000 && colors.iter().flatten().all(|value| *value == 0.0));
    assert!(black_png(8192).len() < 500_000);
    let error = image::read(&empty_exr(16, UNCOMPRESSED), Some(Path::new("a.exr")), image::Encoding::Srgb);
    assert!(empty_exr(40_000, DWAA).len() < 21_000 && error.is_err());
}
