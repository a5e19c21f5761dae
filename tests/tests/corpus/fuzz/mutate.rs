//! How files are damaged.

use serde_json::{Map, Value, json};
use surelight_tests::random::Random;

/// Numbers at which checks tend to fail.
const NUMBERS: [f64; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    3.0,
    0.5,
    255.0,
    256.0,
    65535.0,
    65536.0,
    2147483647.0,
    2147483648.0,
    4294967295.0,
    4294967296.0,
    9007199254740991.0,
    9007199254740992.0,
    1.8446744073709552e19,
    1e308,
    -1e38,
];

/// A glTF or glb file with a few changes: in most cases to its JSON's tree, else to its bytes.
pub(crate) fn document(random: &mut Random, seed: &[u8], other: &[u8]) -> Vec<u8> {
    if random.index(4) == 0 {
        return bytes(random, seed, other);
    }
    let Some((mut json, bin)) = split(seed) else { return bytes(random, seed, other) };
    let donor = split(other).map(|(json, _)| json);
    for _ in 0..1 + random.index(3) {
        change(random, &mut json, donor.as_ref());
    }
    let text = json.to_string().into_bytes();
    match bin {
        None => text,
        Some(mut bin) => {
            if random.index(4) == 0 {
                bin = bytes(random, &bin, seed);
            }
            glb(&text, &bin)
        }
    }
}

/// The JSON and, of a glb, the binary chunk.
fn split(file: &[u8]) -> Option<(Value, Option<Vec<u8>>)> {
    if !file.starts_with(b"glTF") {
        return Some((serde_json::from_slice(file).ok()?, None));
    }
    let length = u32::from_le_bytes(file.get(12..16)?.try_into().ok()?) as usize;
    let json = serde_json::from_slice(file.get(20..20_usize.checked_add(length)?)?).ok()?;
    Some((json, Some(file.get(20 + length + 8..).unwrap_or(&[]).to_vec())))
}

fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let mut file = b"glTF".to_vec();
    for word in [2, total as u32, json.len() as u32, 0x4e4f_534a] {
        file.extend(word.to_le_bytes());
    }
    file.extend(&json);
    file.extend((bin.len() as u32).to_le_bytes());
    file.extend(0x004e_4942_u32.to_le_bytes());
    file.extend(bin);
    file
}

/// One change somewhere in a tree. Each step down is taken with equal chance, so that rare branches
/// are changed as often as long arrays.
fn change(random: &mut Random, root: &mut Value, donor: Option<&Value>) {
    let mut at = root;
    loop {
        let children = match at {
            Value::Array(items) => items.len(),
            Value::Object(fields) => fields.len(),
            _ => 0,
        };
        if children == 0 || random.index(8) == 0 {
            return replace(random, at, donor);
        }
        if random.index(8) == 0 {
            return rearrange(random, at);
        }
        let which = random.index(children);
        at = match at {
            Value::Array(items) => &mut items[which],
            Value::Object(fields) => fields.iter_mut().nth(which).expect("a child").1,
            _ => unreachable!("leaves have no children"),
        };
    }
}

fn replace(random: &mut Random, at: &mut Value, donor: Option<&Value>) {
    let number = NUMBERS[random.index(NUMBERS.len())];
    *at = match random.index(8) {
        0..=2 if number.fract() == 0.0 && (0.0..1e19).contains(&number) => json!(number as u64),
        0..=2 => json!(number),
        // A near miss: one more or one less, a number more or less than all there are.
        3 => match at.as_i64() {
            Some(n) => json!(n + [-1, 1, 2, -2][random.index(4)]),
            None => json!(random.index(8)),
        },
        4 => {
            [Value::Null, json!(true), json!(""), json!("\u{0}../a%2fb"), json!([]), json!({})][random.index(6)].clone()
        }
        5 => json!(
            ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "MASK", "BLEND", "CUBICSPLINE", "weights", "rotation"]
                [random.index(10)]
        ),
        6 => json!([5120, 5121, 5122, 5123, 5125, 5126, 0, 1, 2, 3, 4, 5, 6][random.index(13)]),
        // A branch of another file.
        _ => donor.map_or(Value::Null, |donor| branch(random, donor).clone()),
    };
}

/// Some branch of a tree.
fn branch<'a>(random: &mut Random, mut at: &'a Value) -> &'a Value {
    loop {
        at = match at {
            Value::Array(items) if !items.is_empty() && random.index(4) > 0 => &items[random.index(items.len())],
            Value::Object(fields) if !fields.is_empty() && random.index(4) > 0 => {
                fields.values().nth(random.index(fields.len())).expect("a child")
            }
            _ => return at,
        }
    }
}

/// Removes, repeats or exchanges children.
fn rearrange(random: &mut Random, at: &mut Value) {
    match at {
        Value::Array(items) if !items.is_empty() => {
            let [a, b] = [0; 2].map(|_| random.index(items.len()));
            match random.index(4) {
                0 => drop(items.remove(a)),
                1 => items.insert(a, items[b].clone()),
                2 => items.swap(a, b),
                _ => items.truncate(a),
            }
        }
        Value::Object(fields) if !fields.is_empty() => {
            let keys: Vec<String> = fields.keys().cloned().collect();
            let [a, b] = [0; 2].map(|_| &keys[random.index(keys.len())]);
            if random.index(2) == 0 {
                fields.remove(a);
            } else {
                // A value under another's name.
                let copy: Map<String, Value> = fields.clone();
                fields.insert(a.clone(), copy[b].clone());
            }
        }
        _ => {}
    }
}

/// A file with a few of its bytes changed: bits, words at which checks tend to fail, blocks moved
/// or lost, its end cut off.
pub(crate) fn bytes(random: &mut Random, seed: &[u8], other: &[u8]) -> Vec<u8> {
    let mut file = seed.to_vec();
    for _ in 0..1 + random.index(3) {
        if file.is_empty() {
            break;
        }
        // Headers are short, and most that is checked is there.
        let reach = if random.index(2) == 0 { file.len().min(256) } else { file.len() };
        let at = random.index(reach);
        match random.index(8) {
            0..=2 => file[at] ^= 1 << random.index(8),
            3 => file[at] = [0, 1, 127, 128, 255][random.index(5)],
            4 => {
                let word = [0_u32, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x0001_0000][random.index(6)];
                for (byte, new) in file[at..].iter_mut().zip(word.to_le_bytes()) {
                    *byte = new;
                }
            }
            5 => file.truncate(at),
            6 => {
                let end = (at + 1 + random.index(64)).min(file.len());
                file.drain(at..end);
            }
            _ => {
                let from = random.index(other.len().max(1));
                let block = &other[from.min(other.len())..(from + 64).min(other.len())];
                file.splice(at..at, block.iter().copied());
            }
        }
    }
    file
}
