//! Tests, on the parsed shaders, that hair is lit in a single function.

use crate::frame::PASSES;
use naga::{Expression, Function, Handle, Module, Statement, Type};
use std::collections::BTreeSet;

fn calls_in(block: &naga::Block, found: &mut BTreeSet<Handle<Function>>) {
    for statement in block {
        match statement {
            Statement::Call { function, .. } => drop(found.insert(*function)),
            Statement::Block(block) => calls_in(block, found),
            Statement::If { accept, reject, .. } => [accept, reject].into_iter().for_each(|b| calls_in(b, found)),
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| calls_in(&case.body, found)),
            Statement::Loop { body, continuing, .. } => [body, continuing].into_iter().for_each(|b| calls_in(b, found)),
            _ => {}
        }
    }
}

fn calls(module: &Module, function: &Function) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    calls_in(&function.body, &mut found);
    found.iter().filter_map(|handle| module.functions[*handle].name.clone()).collect()
}

fn reaches(module: &Module, function: &Function) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open: Vec<String> = calls(module, function).into_iter().collect();
    while let Some(name) = open.pop() {
        if let Some((_, next)) = module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(&name)) {
            open.extend(calls(module, next));
        }
        if !found.insert(name) {
            open.retain(|name| !found.contains(name));
        }
    }
    found
}

/// Returns the names of the functions that call `callee`.
fn callers(module: &Module, callee: &str) -> BTreeSet<String> {
    let functions = module.functions.iter().map(|(_, f)| (f.name.clone().unwrap_or_default(), f));
    let entries = module.entry_points.iter().map(|e| (e.name.clone(), &e.function));
    functions.chain(entries).filter(|(_, f)| calls(module, f).contains(callee)).map(|(name, _)| name).collect()
}

fn set<const N: usize>(names: [&str; N]) -> BTreeSet<String> {
    names.map(String::from).into()
}

#[test]
fn hair_is_lit_in_one_function() {
    let mut geometries = BTreeSet::new();
    for shader in PASSES.iter().flat_map(|pass| pass.shaders) {
        let module = naga::front::wgsl::parse_str(&shader.wgsl()).unwrap();
        for entry in module.entry_points.iter().filter(|e| e.stage == naga::ShaderStage::Fragment) {
            let reached = reaches(&module, &entry.function);
            // Every entry point that calls `fibre` must also call `light_hair`.
            if reached.contains("fibre") {
                assert!(reached.contains("light_hair"), "{}: {}", shader.name, entry.name);
                geometries.insert(entry.name.clone());
            }
        }
        let has = |name: &str| module.functions.iter().any(|(_, f)| f.name.as_deref() == Some(name));
        if !has("light_hair") {
            assert!(!has("fibre"), "{}", shader.name);
            continue;
        }
        // Only `light_hair` may call the functions of the lights, and only they may call `fibre`, except in the study
        // of lighting at vertices.
        for light in ["key_light_on_hair", "fill_lights_on_hair"] {
            assert_eq!(callers(&module, light), set(["light_hair"]), "{}", shader.name);
        }
        let mut of_fibre = callers(&module, "fibre");
        of_fibre.remove("half_or_factors");
        assert_eq!(of_fibre, set(["fill_lights_on_hair", "key_fibre"]), "{}", shader.name);
        assert_eq!(callers(&module, "key_fibre"), set(["key_light_on_hair"]), "{}", shader.name);
        // Every function that builds a `HairPoint`, at once or member by member, must pass it to `light_hair`.
        let is_point = |ty: Handle<Type>| module.types[ty].name.as_deref() == Some("HairPoint");
        for (_, function) in module.functions.iter() {
            let composes = function.expressions.iter().any(|(_, e)| match e {
                Expression::Compose { ty, .. } => is_point(*ty),
                _ => false,
            });
            let builds = composes || function.local_variables.iter().any(|(_, variable)| is_point(variable.ty));
            assert!(!builds || calls(&module, function).contains("light_hair"), "{:?}", function.name);
        }
    }
    assert_eq!(
        geometries,
        set(["fs_fins", "fs_furred", "fs_shells", "fs_shells_filled", "fs_shells_mapped"]),
        "what is lit as hair"
    );
}

#[test]
fn second_lighting_function_is_detected() {
    let shader = "
        fn fibre() -> f32 { return 1.0; }
        fn light_hair() -> f32 { return fibre(); }
        @fragment fn good() -> @location(0) vec4<f32> { return vec4(light_hair()); }
        @fragment fn bad() -> @location(0) vec4<f32> { return vec4(fibre()); }
    ";
    let module = naga::front::wgsl::parse_str(shader).unwrap();
    assert_eq!(callers(&module, "fibre"), set(["bad", "light_hair"]));
    let reached = |k: usize| reaches(&module, &module.entry_points[k].function);
    assert_eq!((reached(0), reached(1)), (set(["fibre", "light_hair"]), set(["fibre"])));
}
