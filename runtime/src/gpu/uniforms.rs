//! Ring of uniform buffers: each frame writes its uniforms to a slot that no other frame uses.

use super::device::Gpu;
use bytemuck::Pod;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Minimum size of a slot's buffers, bytes; larger if a single upload needs more.
const CHUNK_BYTES: u64 = 64 << 10;

/// Free slots kept for later frames.
const SPARE_SLOTS: usize = 16;

/// Location of uploaded data: `offset` bytes into a buffer of the slot.
#[derive(Clone, Debug)]
pub(crate) struct UniformRange {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) offset: u64,
    /// Bytes from one element to the next.
    pub(crate) stride: u64,
}

#[derive(Debug)]
struct Chunk {
    buffer: wgpu::Buffer,
    bytes: Vec<u8>,
    /// Number of bytes already handed to the queue.
    written: usize,
    /// Contents last handed to the queue.
    held: Vec<u8>,
}

/// Slot of the ring while a frame is prepared: collects bytes and writes them all at once.
#[derive(Debug)]
pub(crate) struct UniformSlot {
    chunks: Vec<Chunk>,
    /// Reference count of the slot. The frame holds a reference as long as it uses the slot.
    in_use: Arc<()>,
    alignment: u64,
    /// Number of bytes that this frame uploaded.
    uploaded: u64,
}

impl UniformSlot {
    fn new(gpu: &Gpu) -> Self {
        let limits = gpu.device.limits();
        let alignment = limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment);
        Self { chunks: Vec::new(), in_use: Arc::new(()), alignment: u64::from(alignment), uploaded: 0 }
    }

    /// Appends values, each at an offset that is valid for a binding.
    pub(crate) fn put<T: Pod>(&mut self, gpu: &Gpu, values: &[T]) -> UniformRange {
        let stride = (size_of::<T>() as u64).next_multiple_of(self.alignment);
        self.put_bytes(gpu, stride, values.iter().map(bytemuck::bytes_of))
    }

    /// Appends an array, tightly packed.
    pub(crate) fn put_array<T: Pod>(&mut self, gpu: &Gpu, values: &[T]) -> UniformRange {
        let bytes = bytemuck::cast_slice(values);
        let stride = (bytes.len() as u64).next_multiple_of(self.alignment);
        self.put_bytes(gpu, stride, std::iter::once(bytes))
    }

    fn put_bytes<'b>(
        &mut self,
        gpu: &Gpu,
        stride: u64,
        values: impl ExactSizeIterator<Item = &'b [u8]>,
    ) -> UniformRange {
        let needed = stride * values.len().max(1) as u64;
        let fits = |chunk: &Chunk| chunk.bytes.len() as u64 + needed <= chunk.buffer.size();
        let index = self.chunks.iter().position(fits).unwrap_or_else(|| {
            let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            // Leave room to grow: otherwise a herd that grows by one per frame would create a buffer in each frame.
            let buffer = gpu.buffer("pelage uniforms", needed.next_power_of_two().max(CHUNK_BYTES), usage);
            self.chunks.push(Chunk { buffer, bytes: Vec::new(), written: 0, held: Vec::new() });
            self.chunks.len() - 1
        });
        let chunk = &mut self.chunks[index];
        let offset = chunk.bytes.len();
        for (k, value) in values.enumerate() {
            chunk.bytes.resize(offset + k * stride as usize, 0);
            chunk.bytes.extend_from_slice(value);
        }
        chunk.bytes.resize(offset + needed as usize, 0);
        UniformRange { buffer: chunk.buffer.clone(), offset: offset as u64, stride }
    }

    /// Uploads the bytes that the queue does not have yet; nothing if the slot holds the same bytes from an earlier
    /// frame.
    pub(crate) fn write(&mut self, gpu: &Gpu) {
        for chunk in &mut self.chunks {
            let (from, to) = (chunk.written, chunk.bytes.len());
            let new = &chunk.bytes[from..];
            if chunk.held.get(from..to) != Some(new) {
                gpu.queue.write_buffer(&chunk.buffer, from as u64, new);
                self.uploaded += new.len() as u64;
                chunk.held.resize(chunk.held.len().max(to), 0);
                chunk.held[from..to].copy_from_slice(new);
            }
            chunk.written = to;
        }
    }

    /// Returns the number of bytes that this frame has uploaded so far.
    pub(crate) fn uploaded(&self) -> u64 {
        self.uploaded
    }
}

/// Slots of the ring. A slot is free once its frame is dropped and its commands have either finished or been dropped
/// unsubmitted.
#[derive(Debug, Default)]
pub(crate) struct UniformRing {
    slots: Vec<UniformSlot>,
    /// Set when an encoder is dropped instead of submitted, although a frame was prepared into it.
    lost: Arc<AtomicBool>,
}

/// Holds a slot. Dropping it without [`SubmissionGuard::done`] means that the recorded commands never ran.
struct SubmissionGuard {
    in_use: Option<Arc<()>>,
    lost: Arc<AtomicBool>,
}

impl SubmissionGuard {
    fn done(mut self) {
        self.in_use = None;
    }
}

impl Drop for SubmissionGuard {
    fn drop(&mut self) {
        if self.in_use.is_some() {
            self.lost.store(true, Ordering::Relaxed);
        }
    }
}

impl UniformRing {
    pub(crate) fn acquire(&mut self, gpu: &Gpu) -> UniformSlot {
        let free = self.slots.iter().position(|slot| Arc::strong_count(&slot.in_use) == 1);
        let mut slot = free.map_or_else(|| UniformSlot::new(gpu), |index| self.slots.swap_remove(index));
        // Drop surplus slots, which were needed while many frames were in flight.
        let mut spare = 0;
        self.slots.retain(|slot| {
            spare += usize::from(Arc::strong_count(&slot.in_use) == 1);
            spare <= SPARE_SLOTS || Arc::strong_count(&slot.in_use) > 1
        });
        slot.chunks.retain(|chunk| !chunk.bytes.is_empty());
        for chunk in &mut slot.chunks {
            chunk.bytes.clear();
            chunk.written = 0;
        }
        slot.uploaded = 0;
        slot
    }

    /// Returns the slot of a frame prepared into `encoder` to the ring. The frame keeps the returned handle, which
    /// marks the slot as in use.
    pub(crate) fn release(&mut self, slot: UniformSlot, encoder: &wgpu::CommandEncoder) -> Arc<()> {
        let in_use = slot.in_use.clone();
        let submitted = SubmissionGuard { in_use: Some(in_use.clone()), lost: self.lost.clone() };
        encoder.on_submitted_work_done(move || submitted.done());
        self.slots.push(slot);
        in_use
    }

    /// Whether recorded commands were lost since the last call.
    pub(crate) fn lost_work(&self) -> bool {
        self.lost.swap(false, Ordering::Relaxed)
    }
}
