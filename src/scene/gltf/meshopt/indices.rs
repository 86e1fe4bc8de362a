//! Modes 1 and 2: triangles by the edges and vertices that they share, and indices by their differences
//! (KHR_meshopt_compression, appendix A).

use super::{Codes, header};

/// The last sixteen of what was pushed.
struct Recent<T> {
    items: [T; 16],
    pushed: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { items: [T::default(); 16], pushed: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.pushed % 16] = item;
        self.pushed += 1;
    }

    /// Pushed before the last `back` ones.
    fn get(&self, back: usize) -> Result<T, String> {
        match self.pushed.checked_sub(back + 1) {
            Some(at) => Ok(self.items[at % 16]),
            None => Err("refers to something before its first triangle".into()),
        }
    }
}

/// A list in the making.
struct Indices {
    bytes: Vec<u8>,
    size: usize,
}

impl Indices {
    fn new(count: usize, size: usize) -> Self {
        Self { bytes: Vec::with_capacity(count * size), size }
    }

    fn push(&mut self, index: u32) {
        self.bytes.extend_from_slice(&index.to_le_bytes()[..self.size]);
    }
}

struct Triangles<'a> {
    data: Codes<'a>,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    /// The index after all that came first in their order.
    next: u32,
    last: u32,
}

pub fn decode_triangles(codes: &[u8], count: usize, size: usize) -> Result<Vec<u8>, String> {
    header(codes, &[0xe1])?;
    let (triangles, rest) = codes[1..].split_at_checked(count / 3).ok_or("ends within the triangles")?;
    let (data, table) = rest.split_last_chunk::<16>().ok_or("ends before the table")?;
    if table[14..] != [0, 0] || table.iter().any(|&pair| pair >> 4 == 15 || pair & 15 == 15) {
        return Err("has a table that is none".into());
    }
    let mut out = Indices::new(count, size);
    let (edges, vertices) = (Recent::new(), Recent::new());
    let mut state = Triangles { data: Codes(data), edges, vertices, next: 0, last: 0 };
    for &code in triangles {
        let [a, b, c] = match (code >> 4, code & 15) {
            (15, third) => state.apart(third, table)?,
            (edge, third) => state.beside(edge, third)?,
        };
        [a, b, c].into_iter().for_each(|index| out.push(index));
    }
    state.data.end()?;
    Ok(out.bytes)
}

impl Triangles<'_> {
    /// A triangle at an edge of one before.
    fn beside(&mut self, edge: u8, third: u8) -> Result<[u32; 3], String> {
        let [a, b] = self.edges.get(edge.into())?;
        let c = match third {
            0 => self.next(),
            13 => self.step(u32::MAX),
            14 => self.step(1),
            15 => self.explicit()?,
            known => self.vertices.get(known.into())?,
        };
        if !(1..13).contains(&third) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// A triangle without such an edge.
    fn apart(&mut self, code: u8, table: &[u8; 16]) -> Result<[u32; 3], String> {
        let pair = match table.get(usize::from(code)) {
            Some(&pair) if code < 14 => pair,
            _ => self.data.byte()?,
        };
        if code >= 14 && pair == 0 {
            self.next = 0;
        }
        let a = if code == 15 { self.explicit()? } else { self.next() };
        let b = self.other(pair >> 4)?;
        let c = self.other(pair & 15)?;
        self.vertices.push(a);
        for (index, code) in [(b, pair >> 4), (c, pair & 15)] {
            if code == 0 || code == 15 {
                self.vertices.push(index);
            }
        }
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        Ok([a, b, c])
    }

    fn other(&mut self, code: u8) -> Result<u32, String> {
        match code {
            0 => Ok(self.next()),
            15 => self.explicit(),
            known => self.vertices.get(usize::from(known) - 1),
        }
    }

    fn next(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn step(&mut self, delta: u32) -> u32 {
        self.last = self.last.wrapping_add(delta);
        self.last
    }

    fn explicit(&mut self) -> Result<u32, String> {
        let code = varint(&mut self.data)?;
        Ok(self.step(dezigzag(code)))
    }
}

pub fn decode_sequence(codes: &[u8], count: usize, size: usize) -> Result<Vec<u8>, String> {
    header(codes, &[0xd1])?;
    let (data, _) = codes[1..].split_last_chunk::<4>().ok_or("ends before its padding")?;
    if data.len() < count {
        return Err(format!("is too short for {count} indices"));
    }
    let mut data = Codes(data);
    let mut out = Indices::new(count, size);
    let mut last = [0_u32; 2];
    for _ in 0..count {
        let code = varint(&mut data)?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(dezigzag(code >> 1));
        out.push(*last);
    }
    data.end()?;
    Ok(out.bytes)
}

/// LEB128 of at most five bytes.
fn varint(data: &mut Codes) -> Result<u32, String> {
    let mut value = 0;
    for shift in [0, 7, 14, 21, 28] {
        let byte = data.byte()?;
        value |= u32::from(byte & 127) << shift;
        if byte < 128 {
            return Ok(value);
        }
    }
    Err("has a number of more than five bytes".into())
}

fn dezigzag(code: u32) -> u32 {
    code >> 1 ^ (code & 1).wrapping_neg()
}
