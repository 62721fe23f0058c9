//! Allocation tests: opening a large package allocates next to nothing, and no read allocates more than in proportion
//! to the file, whatever lengths the file states.
#![allow(unsafe_code, reason = "only a global allocator sees every allocation")]

use crate::bodies::reseal;
use crate::common;
use pelage_formats::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Allocator that counts the bytes of each thread, so that tests can run in parallel.
struct CountingAllocator;

thread_local! {
    /// Bytes allocated minus bytes freed by this thread. Negative if the thread frees memory of another.
    static NOW: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn count(bytes: isize) {
    let now = NOW.get() + bytes;
    NOW.set(now);
    PEAK.set(PEAK.get().max(now));
}

// SAFETY: every call goes to the system's allocator unchanged; the counters neither allocate nor have destructors.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's layout is passed on unchanged.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller's pointer and layout are passed on unchanged.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Returns the peak number of bytes that this thread allocated while `f` ran, beyond those allocated before.
fn peak<T>(f: impl FnOnce() -> T) -> (usize, T) {
    let before = NOW.get();
    PEAK.set(before);
    let result = f();
    ((PEAK.get() - before) as usize, result)
}

#[test]
fn allocations_stay_small_for_any_stored_length() {
    let (seen, _) = peak(|| vec![0u8; 1 << 20]);
    assert!(seen >= 1 << 20, "the counter counts");

    let pixels = vec![7u8; 50 << 20];
    let bytes = PackageWriter::new(Manifest::default()).section(Tag(*b"DATA"), pixels).finish().unwrap();
    let (seen, package) = peak(|| Package::open(&bytes, &Limits::default()).unwrap());
    assert!(seen < 64 << 10, "opening 50 MiB allocated {seen} bytes");
    let (seen, _) = peak(|| package.section_bytes(1).unwrap().len());
    assert!(seen < 1 << 10, "reading a section allocated {seen} bytes");

    // In turn, replace every eight bytes of manifest and animation by an enormous length, and correct the checksums.
    let good = common::sample_package();
    let sections = Package::open(&good, &Limits::default()).unwrap().sections().to_vec();
    let mut refused = 0;
    for section in [sections[0], sections[2]] {
        for at in section.offset..section.offset + section.length - 8 {
            for length in [1u64 << 16, 1 << 24, 1 << 32, 1 << 40, i64::MAX as u64, 1 << 63, u64::MAX] {
                let mut bytes = good.clone();
                bytes[at as usize..at as usize + 8].copy_from_slice(&length.to_le_bytes());
                reseal(&mut bytes);
                let (seen, faults) = peak(|| Package::validate(&bytes, &Limits::default()));
                // Serde reserves 1 MiB for each of three nested lists; a string adds 64 KiB.
                assert!(seen < 4 << 20, "length {length} at byte {at} made the reader allocate {seen} bytes");
                refused += faults.len().min(1);
            }
        }
    }
    assert!(refused > 1000, "only {refused} of the lengths were refused");
}
