//! EXT_meshopt_compression: the codecs for vertices, triangles and index lists, and the filters (appendices A and B of
//! the extension).
//!
//! Every read is checked: any input gives an error or a result. The size of the input bounds that of the output: one
//! byte yields at most 64 bytes of vertices, or one triangle.

/// Reason why bytes cannot be decoded. The caller puts a text before it that ends in "is compressed with meshopt".
pub(super) type Fault = String;

/// Cursor over bytes, read from the front.
struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self
            .rest
            .split_at_checked(count)
            .ok_or_else(|| format!("and cut off: {count} more bytes are expected, {} are left", self.rest.len()))?;
        self.rest = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, Fault> {
        Ok(self.take(1)?[0])
    }

    /// Reads a number stored in groups of seven bits, lowest first. 32 bits need five groups.
    fn varint(&mut self) -> Result<u32, Fault> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f).wrapping_shl(shift);
            if byte < 0x80 {
                break;
            }
        }
        Ok(value)
    }
}

/// Checks that the first byte is `header`, and splits off the last `tail` bytes. Returns a reader of the bytes between
/// them, and the bytes split off.
fn frame<'a>(bytes: &'a [u8], header: u8, tail: usize) -> Result<(Reader<'a>, &'a [u8]), Fault> {
    let Some((found, rest)) = bytes.split_first() else { return Err("and empty".into()) };
    if *found != header {
        return Err(format!("and begins with {found:#04x}, expected {header:#04x}"));
    }
    let split = rest.len().checked_sub(tail);
    let (rest, tail) = rest
        .split_at(split.ok_or_else(|| {
            format!("and has {} bytes, expected a header byte and at least {tail} more", bytes.len())
        })?);
    Ok((Reader { rest }, tail))
}

fn end(reader: &Reader<'_>) -> Result<(), Fault> {
    match reader.rest.len() {
        0 => Ok(()),
        left => Err(format!("and has {left} bytes too many")),
    }
}

/// Undoes zigzag encoding, which maps small signed numbers to small unsigned ones.
fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}

/// Limits of a vertex block: at most 256 elements and at most 8 KiB. The number of elements is a multiple of `GROUP`;
/// the last block is padded.
const BLOCK_BYTES: usize = 8192;
const BLOCK_ELEMENTS: usize = 256;
const GROUP: usize = 16;

/// Decodes `count` elements of `stride` bytes (mode `ATTRIBUTES`). `stride` is a multiple of 4, 4..=256.
pub(super) fn decode_vertices(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    // The first element, from which all deltas start, is at the very end. Zeros before it pad it to 32 bytes.
    let (mut reader, tail) = frame(bytes, 0xa0, stride.max(32))?;
    let mut last = tail[tail.len() - stride..].to_vec();
    let most = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(BLOCK_ELEMENTS);
    let mut out = Vec::new();
    let mut deltas = [0; BLOCK_ELEMENTS];
    let mut done = 0;
    while done < count {
        let elements = most.min(count - done);
        let start = out.len();
        for k in 0..stride {
            decode_bytes(&mut reader, &mut deltas[..elements.next_multiple_of(GROUP)])?;
            // Allocate only after the first channel was read: its bytes bound the allocation.
            out.resize(start + elements * stride, 0);
            for (element, delta) in out[start..].chunks_exact_mut(stride).zip(&deltas) {
                last[k] = last[k].wrapping_add(unzigzag((*delta).into()) as u8);
                element[k] = last[k];
            }
        }
        done += elements;
    }
    end(&reader)?;
    Ok(out)
}

/// Decodes one byte of each element of a block, in groups of 16. Each group stores 0, 2, 4 or 8 bits per byte.
fn decode_bytes(reader: &mut Reader<'_>, out: &mut [u8]) -> Result<(), Fault> {
    let groups = out.len() / GROUP;
    let header = reader.take(groups.div_ceil(4))?;
    for (g, group) in out.chunks_exact_mut(GROUP).enumerate() {
        let bits = match (header[g / 4] >> (2 * (g % 4))) & 3 {
            0 => {
                group.fill(0);
                continue;
            }
            3 => {
                group.copy_from_slice(reader.take(GROUP)?);
                continue;
            }
            mode => 2 * u32::from(mode),
        };
        let packed = reader.take(GROUP * bits as usize / 8)?;
        let (per_byte, escape) = (8 / bits as usize, (1_u8 << bits) - 1);
        for (i, slot) in group.iter_mut().enumerate() {
            let shift = 8 - bits * (1 + (i % per_byte) as u32);
            let value = (packed[i / per_byte] >> shift) & escape;
            // The largest value is an escape: the byte itself is stored after the group.
            *slot = if value == escape { reader.byte()? } else { value };
        }
    }
    Ok(())
}

/// The last sixteen entries pushed; `get(0)` is the newest.
struct Recent<T> {
    entries: [T; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new(empty: T) -> Self {
        Self { entries: [empty; 16], next: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.next] = entry;
        self.next = (self.next + 1) % 16;
    }

    fn get(&self, age: usize) -> T {
        self.entries[(self.next + 15 - age) % 16]
    }
}

/// State of the triangle decoder. Vertex indices are derived from it.
struct Triangles<'a> {
    data: Reader<'a>,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    /// Smallest index not yet used.
    next: u32,
    /// Last vertex index that the data stored explicitly. The next one is stored as the difference from it.
    last: u32,
}

impl Triangles<'_> {
    fn fresh(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }

    fn written(&mut self) -> Result<u32, Fault> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Ok(self.last)
    }

    /// Returns the vertex that `code` stands for: a new one, one stored explicitly, or a recent one. Also returns
    /// whether to add it to the recent vertices.
    fn vertex(&mut self, code: u8) -> Result<(u32, bool), Fault> {
        Ok(match code {
            0 => (self.fresh(), true),
            15 => (self.written()?, true),
            age => (self.vertices.get(usize::from(age) - 1), false),
        })
    }

    /// Decodes a triangle that shares a recent edge.
    fn on_edge(&mut self, code: u8) -> Result<[u32; 3], Fault> {
        let [a, b] = self.edges.get(usize::from(code >> 4));
        let (c, new) = match code & 15 {
            0 => (self.fresh(), true),
            13 => {
                self.last = self.last.wrapping_sub(1);
                (self.last, true)
            }
            14 => {
                self.last = self.last.wrapping_add(1);
                (self.last, true)
            }
            15 => (self.written()?, true),
            age => (self.vertices.get(age.into()), false),
        };
        if new {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// Decodes a triangle that shares no recent edge, from the codes of its corners.
    fn without_edge(&mut self, a: u8, b: u8, c: u8) -> Result<[u32; 3], Fault> {
        // All new vertices of the triangle are numbered before any explicit index is read.
        let mut corners = [(0, false); 3];
        for (corner, code) in corners.iter_mut().zip([a, b, c]).filter(|(_, code)| *code != 15) {
            *corner = self.vertex(code)?;
        }
        for (corner, code) in corners.iter_mut().zip([a, b, c]).filter(|(_, code)| *code == 15) {
            *corner = self.vertex(code)?;
        }
        for (index, _) in corners.iter().filter(|(_, new)| *new) {
            self.vertices.push(*index);
        }
        let [a, b, c] = corners.map(|(index, _)| index);
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        Ok([a, b, c])
    }
}

/// Decodes `count` indices of a triangle list (mode `TRIANGLES`). `count` is a multiple of 3.
pub(super) fn decode_triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, Fault> {
    let (mut reader, table) = frame(bytes, 0xe1, 16)?;
    let codes = reader.take(count / 3)?;
    let mut state = Triangles {
        data: reader,
        edges: Recent::new([u32::MAX; 2]),
        vertices: Recent::new(u32::MAX),
        next: 0,
        last: 0,
    };
    let mut out = Vec::with_capacity(count);
    for code in codes {
        let triangle = match *code {
            code @ 0..0xf0 => state.on_edge(code)?,
            code @ 0xf0..0xfe => {
                let pair = table[usize::from(code & 15)];
                state.without_edge(0, pair >> 4, pair & 15)?
            }
            code => {
                let pair = state.data.byte()?;
                if pair == 0 {
                    // A pair of 0 restarts the numbering of new vertices.
                    state.next = 0;
                }
                state.without_edge(if code == 0xfe { 0 } else { 15 }, pair >> 4, pair & 15)?
            }
        };
        out.extend(triangle);
    }
    end(&state.data)?;
    Ok(out)
}

/// Decodes `count` indices in any order (mode `INDICES`).
pub(super) fn decode_indices(bytes: &[u8], count: usize) -> Result<Vec<u32>, Fault> {
    // The data ends with four bytes of padding.
    let (mut reader, _) = frame(bytes, 0xd1, 4)?;
    let mut last = [0_u32; 2];
    let mut out = Vec::new();
    for _ in 0..count {
        let value = reader.varint()?;
        let slot = &mut last[(value & 1) as usize];
        *slot = slot.wrapping_add(unzigzag(value >> 1));
        out.push(*slot);
    }
    end(&reader)?;
    Ok(out)
}

/// Undoes a filter on decoded vertices, in place.
///
/// * `OCTAHEDRAL`, stride 4 or 8: unit vectors of signed normalized integers; the fourth component is unchanged
/// * `QUATERNION`, stride 8: rotations as four 16-bit integers
/// * `EXPONENTIAL`, any stride: floats with 24 bits of mantissa and 8 of exponent
pub(super) fn unfilter(name: &str, stride: usize, bytes: &mut [u8]) -> Result<(), Fault> {
    match (name, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => {
            for v in bytes.as_chunks_mut::<4>().0 {
                let [x, y, z] = octahedral([v[0], v[1], v[2]].map(|b| f32::from(b as i8)), 127.0);
                [v[0], v[1], v[2]] = [x as i8 as u8, y as i8 as u8, z as i8 as u8];
            }
        }
        ("OCTAHEDRAL", 8) => {
            for v in bytes.as_chunks_mut::<8>().0 {
                let [x, y, z, w] = shorts(*v);
                let [x, y, z] = octahedral([x, y, z].map(f32::from), 32_767.0).map(|c| c as i16);
                *v = from_shorts([x, y, z, w]);
            }
        }
        ("QUATERNION", 8) => bytes.as_chunks_mut::<8>().0.iter_mut().for_each(|v| *v = quaternion(shorts(*v))),
        ("EXPONENTIAL", _) => {
            for v in bytes.as_chunks_mut::<4>().0 {
                let bits = i32::from_le_bytes(*v);
                let (exponent, mantissa) = (bits >> 24, (bits << 8) >> 8);
                // For the smallest exponents this expression is not 2^e; the extension forbids encoders to use them.
                *v = (mantissa as f32 * f32::from_bits(((exponent + 127) as u32) << 23)).to_le_bytes();
            }
        }
        _ => {
            return Err(format!(
                "and has the filter {name} on elements of {stride} bytes, which the extension does not define"
            ));
        }
    }
    Ok(())
}

fn shorts(v: [u8; 8]) -> [i16; 4] {
    [0, 2, 4, 6].map(|i| i16::from_le_bytes([v[i], v[i + 1]]))
}

fn from_shorts(v: [i16; 4]) -> [u8; 8] {
    let [a, b, c, d] = v.map(i16::to_le_bytes);
    [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]]
}

/// Returns a unit vector, scaled by `max` and rounded, from its octahedral projection. `one` is the number that
/// represents 1 in `x` and `y`.
fn octahedral([x, y, one]: [f32; 3], max: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    // The lower half of the octahedron is folded outwards.
    let fold = z.min(0.0);
    let fold_back = |c: f32| if c < 0.0 { c - fold } else { c + fold };
    let (x, y) = (fold_back(x), fold_back(y));
    let scale = max / (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|c| (c * scale).round())
}

/// Returns a quaternion of 16-bit integers, decoded from its three smallest components.
fn quaternion([x, y, z, w]: [i16; 4]) -> [u8; 8] {
    // The two lowest bits of `w` say which component is omitted. `w` with both bits set is the number that represents
    // √½ in the other components.
    let unit = f32::from(w | 3);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / unit;
    let parts = [x, y, z].map(|c| f32::from(c) * scale);
    let rest = (1.0 - parts.iter().map(|c| c * c).sum::<f32>()).max(0.0).sqrt();
    let mut out = [0; 4];
    let missing = (w & 3) as usize;
    for (i, part) in [rest, parts[0], parts[1], parts[2]].into_iter().enumerate() {
        out[(missing + i) % 4] = (part * 32_767.0).round() as i16;
    }
    from_shorts(out)
}
