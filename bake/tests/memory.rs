//! Memory of repeated bakes. The counting allocator of this binary is global, so it has no other test.
#![allow(unsafe_code, reason = "only a global allocator sees every allocation")]
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use pelage_bake::io::{Reach, read_model};
use pelage_bake::pipeline::BakeInput;
use pelage_bake::rebake::Rebake;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_import::ImportOptions;
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// System allocator that counts the live bytes of all threads.
struct CountingAllocator;

/// Live bytes: allocated and not yet freed.
static LIVE: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator unchanged, and the counter does not allocate.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LIVE.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller fulfils the same contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller fulfils the same contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

const BAKES: usize = 100;
/// Number of bakes after which every stage has run with several values of its keys.
const SETTLED: usize = 40;
/// Maximum growth of live memory from bake `SETTLED` to the last. A package of this test has 300 KiB, and its strands
/// and layers have more.
const MOST_GROWTH: usize = 1 << 18;

#[test]
fn a_hundred_bakes_use_the_memory_of_one() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models/torus.glb");
    let model = read_model(&path, &ImportOptions { unit_m: 1.0 }, Reach::OwnFolder).unwrap();
    let images = MapImages::default();
    let recipe = |edit: usize| {
        let mut recipe = Recipe::default();
        let small = ["slice.layers=4", "slice.tile_texels=16", "hair.density=10", "underfur.density=0"];
        // Every twentieth edit changes the strands, and thus almost all stages; every edit changes the last stage.
        let edits = [format!("hair.lean=0.{:02}", 10 + edit / 20), format!("shading.ambient=[0.{edit:02}, 0.1, 0.1]")];
        small.map(str::to_owned).iter().chain(&edits).for_each(|set| recipe.set(set).unwrap());
        recipe
    };
    let recipes: Vec<Recipe> = (0..BAKES).map(recipe).collect();
    let mut rebake = Rebake::new(&model);
    let mut live = Vec::with_capacity(BAKES);
    for recipe in &recipes {
        let baked = rebake.bake(&BakeInput::new("torus", "torus", recipe, &images), &mut |_| ()).unwrap();
        assert!(!baked.package.is_empty());
        drop(baked);
        live.push(LIVE.load(Ordering::Relaxed));
    }
    let (settled, last) = (live[SETTLED], live[BAKES - 1]);
    assert!(last < settled + MOST_GROWTH, "{settled} bytes after {SETTLED} bakes, {last} after {BAKES}");
}
