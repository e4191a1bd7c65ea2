//! Models of small scenes, read back from their bytes.

mod leaves;
mod map;
mod outer_walls;
mod region;
mod scene_parts;
mod surfaces;

use glanz_formats::registry::{Options, load_str};
use glanz_scene::{Description, Scene};
use serde_json::Value;

use super::Model;

/// A model as a page reads it.
struct File {
    head: Value,
    blocks: Vec<u8>,
}

impl File {
    fn read(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..8], b"GLANZVW1");
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(word(12), 0);
        let end = 16 + word(8);
        let start = end.next_multiple_of(16);
        assert!(bytes[end..start].iter().all(|&b| b == 0));
        Self { head: serde_json::from_slice(&bytes[16..end]).unwrap(), blocks: bytes[start..].to_vec() }
    }

    fn words(&self, name: &str) -> Vec<u32> {
        let block = &self.head["blocks"][name];
        let (offset, length) = (number(&block["offset"]), number(&block["length"]));
        assert_eq!(offset % 16, 0);
        let bytes = self.blocks[offset..offset + length].chunks_exact(4);
        bytes.map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn floats(&self, name: &str) -> Vec<f64> {
        self.words(name).into_iter().map(|word| f32::from_bits(word).into()).collect()
    }

    fn list(&self, name: &str) -> &[Value] {
        self.head[name].as_array().unwrap()
    }
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn load(text: &str) -> (Description, Scene) {
    let description = load_str("test.pbrt", text, &Options::default()).unwrap().description;
    let scene = Scene::resolve(description.clone()).unwrap().0;
    (description, scene)
}

fn model(text: &str) -> (Model, File, Scene) {
    let (description, scene) = load(text);
    let model = Model::try_new("test", &description, &scene, &description.files).unwrap();
    let file = File::read(&model.to_bytes().unwrap());
    (model, file, scene)
}
