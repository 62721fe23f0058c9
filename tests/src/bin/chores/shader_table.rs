//! Counts the work of each shader variant and updates the table of runtime/docs/performance.md: `chores shader-table`.
//!
//! Draws the built-in hare in several ways, and counts the operations of the shader stages of its passes as naga reads
//! them, with the constants of their pipelines. Branches that the constants exclude are not counted; of other branches,
//! both sides are. A loop over a constant range counts as often as it runs, any other loop once.

use super::performance_table::{replace_table, stdout_of};
use anyhow::Context as _;
use naga::back::pipeline_constants::process_overrides;
use naga::valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator};
use naga::{
    BinaryOperator as Op, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction as Math, Module,
    Statement, TypeInner, UnaryOperator,
};
use pelage_runtime::ShaderVariant;
use pelage_stage::{Cast, Framing, Gpu, Look, NamedPackage, Stage};
use pelage_tests::binary::workspace;
use pelage_tests::chores::ChoreFolder;
use std::collections::{BTreeMap, HashMap};

/// Ways to draw the hare: description, keys of its look, and beginnings of the names of its entry points, which pixels,
/// layers or strands multiply.
const WAYS: [(&str, &[&str], &[&str]); 4] = [
    ("layers, fibres, studio", &["fur.hair=shells"], &["vs_shells", "fs_shells", "fs_furred"]),
    ("layers, fibres, one lamp", &["fur.hair=shells", "light.studio=old"], &["vs_shells", "fs_shells", "fs_furred"]),
    (
        "layers, Kajiya–Kay, one lamp",
        &["fur.hair=shells", "light.studio=old", "fur.scattering=off"],
        &["vs_shells", "fs_shells", "fs_furred"],
    ),
    ("strands, fibres, studio", &["fur.hair=strands"], &["light_strands", "gather"]),
];

/// Work of a shader stage.
#[derive(Clone, Copy, Default)]
struct Work {
    /// Arithmetic operations, per component.
    operations: u64,
    /// Divisions, roots, exponentials, logarithms and trigonometric functions among them.
    special: u64,
    /// Texels that are sampled or loaded; a filtered sample counts once.
    reads: u64,
}

impl Work {
    fn plus(self, other: Self, times: u64) -> Self {
        Self {
            operations: self.operations + times * other.operations,
            special: self.special + times * other.special,
            reads: self.reads + times * other.reads,
        }
    }
}

/// Function under evaluation.
struct Counter<'a> {
    module: &'a Module,
    info: &'a ModuleInfo,
    function: &'a Function,
    types: &'a FunctionInfo,
    /// Local variables whose value is known at the current statement.
    known: HashMap<Handle<LocalVariable>, i64>,
    /// The function has returned.
    ended: bool,
}

fn components(inner: &TypeInner) -> u64 {
    match inner {
        TypeInner::Vector { size, .. } => *size as u64,
        TypeInner::Matrix { columns, rows, .. } => *columns as u64 * *rows as u64,
        _ => 1,
    }
}

/// Returns the work of a function: its arithmetic, and that of the functions it calls.
fn work_of(module: &Module, info: &ModuleInfo, function: &Function, types: &FunctionInfo) -> Work {
    let mut counter = Counter { module, info, function, types, known: HashMap::new(), ended: false };
    for (local, variable) in function.local_variables.iter() {
        if let Some(value) = variable.init.and_then(|init| counter.value(init)) {
            counter.known.insert(local, value);
        }
    }
    counter.block(&function.body)
}

impl Counter<'_> {
    /// Returns the value of an integer or boolean expression, if it is known.
    fn value(&self, expression: Handle<Expression>) -> Option<i64> {
        let literal = |literal: Literal| match literal {
            Literal::Bool(value) => Some(i64::from(value)),
            Literal::U32(value) => Some(i64::from(value)),
            Literal::I32(value) => Some(i64::from(value)),
            _ => None,
        };
        match self.function.expressions[expression] {
            Expression::Literal(value) => literal(value),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(value) => literal(value),
                    _ => None,
                }
            }
            Expression::Load { pointer } => match self.function.expressions[pointer] {
                Expression::LocalVariable(local) => self.known.get(&local).copied(),
                _ => None,
            },
            Expression::Unary { op: UnaryOperator::LogicalNot, expr } => self.value(expr).map(|value| 1 - value),
            Expression::Binary { op, left, right } => {
                let (left, right) = (self.value(left), self.value(right));
                match (op, left, right) {
                    (Op::LogicalAnd, Some(0), _) | (Op::LogicalAnd, _, Some(0)) => Some(0),
                    (Op::LogicalOr, Some(1), _) | (Op::LogicalOr, _, Some(1)) => Some(1),
                    (Op::LogicalAnd, Some(a), Some(b)) => Some(a & b),
                    (Op::LogicalOr, Some(a), Some(b)) => Some(a | b),
                    (Op::Equal, Some(a), Some(b)) => Some(i64::from(a == b)),
                    (Op::NotEqual, Some(a), Some(b)) => Some(i64::from(a != b)),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn expression(&self, expression: Handle<Expression>) -> Work {
        let width = components(self.types[expression].ty.inner_with(&self.module.types));
        let plain = |operations| Work { operations, ..Work::default() };
        let special = |operations| Work { operations, special: operations, reads: 0 };
        match self.function.expressions[expression] {
            Expression::ImageSample { .. } | Expression::ImageLoad { .. } => Work { reads: 1, ..Work::default() },
            Expression::Binary { op: Op::Divide | Op::Modulo, .. } => special(width),
            Expression::Binary { op: Op::Multiply, left, right } => {
                let size = |of: Handle<Expression>| components(self.types[of].ty.inner_with(&self.module.types));
                // Each component of a product of matrices is a sum of products.
                plain(if size(left).max(size(right)) > 4 { size(left).max(size(right)) * 2 } else { width })
            }
            Expression::Math { fun, arg, .. } => match fun {
                Math::Dot => plain(2 * components(self.types[arg].ty.inner_with(&self.module.types)) - 1),
                Math::Length | Math::Distance | Math::Normalize => Work { operations: 6, special: 1, reads: 0 },
                Math::Cross => plain(9),
                Math::Mix | Math::Fma => plain(2 * width),
                Math::SmoothStep => Work { operations: 6 * width, special: width, reads: 0 },
                Math::Sin
                | Math::Cos
                | Math::Tan
                | Math::Asin
                | Math::Acos
                | Math::Atan
                | Math::Atan2
                | Math::Exp
                | Math::Exp2
                | Math::Log
                | Math::Log2
                | Math::Pow
                | Math::Sqrt
                | Math::InverseSqrt => special(width),
                _ => plain(width),
            },
            Expression::Binary { .. }
            | Expression::Unary { .. }
            | Expression::Select { .. }
            | Expression::As { .. } => {
                if self.value(expression).is_some() {
                    Work::default()
                } else {
                    plain(width)
                }
            }
            _ => Work::default(),
        }
    }

    /// Returns how often a loop runs if it counts a known variable up to a constant.
    fn runs(&self, body: &Block) -> u64 {
        let ends = |of: &Block| of.iter().any(|statement| matches!(statement, Statement::Break));
        for statement in body {
            let Statement::If { condition, accept, reject } = statement else { continue };
            if !(ends(accept) || ends(reject)) {
                continue;
            }
            let Expression::Binary { op: Op::Less, left, right } = self.function.expressions[*condition] else { break };
            if let (Some(first), Some(end)) = (self.value(left), self.value(right)) {
                return u64::try_from(end - first).unwrap_or(0);
            }
            break;
        }
        1
    }

    fn block(&mut self, block: &Block) -> Work {
        let mut sum = Work::default();
        for statement in block {
            if self.ended {
                break;
            }
            match statement {
                Statement::Emit(range) => {
                    sum = range.clone().fold(sum, |sum, expression| sum.plus(self.expression(expression), 1));
                }
                Statement::Block(inner) => sum = sum.plus(self.block(inner), 1),
                Statement::If { condition, accept, reject } => match self.value(*condition) {
                    Some(value) => sum = sum.plus(self.block(if value == 0 { reject } else { accept }), 1),
                    None => {
                        let before = self.known.clone();
                        let yes = self.block(accept);
                        let (after, ended) = (std::mem::replace(&mut self.known, before), self.ended);
                        self.ended = false;
                        sum = sum.plus(yes, 1).plus(self.block(reject), 1);
                        self.ended &= ended;
                        self.known.retain(|local, value| after.get(local) == Some(value));
                    }
                },
                Statement::Switch { cases, .. } => {
                    self.known.clear();
                    for case in cases {
                        sum = sum.plus(self.block(&case.body), 1);
                        self.ended = false;
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    let times = self.runs(body);
                    self.known.clear();
                    let work = self.block(body).plus(self.block(continuing), 1);
                    self.known.clear();
                    self.ended = false;
                    sum = sum.plus(work, times);
                }
                Statement::Store { pointer, value } => {
                    if let Expression::LocalVariable(local) = self.function.expressions[*pointer] {
                        match self.value(*value) {
                            Some(value) => self.known.insert(local, value),
                            None => self.known.remove(&local),
                        };
                    }
                }
                Statement::Call { function, .. } => {
                    let called = &self.module.functions[*function];
                    sum = sum.plus(work_of(self.module, self.info, called, &self.info[*function]), 1);
                }
                Statement::Return { .. } | Statement::Kill => self.ended = true,
                _ => {}
            }
        }
        sum
    }
}

/// Returns the work of a variant of a shader.
fn count(variant: &ShaderVariant) -> anyhow::Result<Work> {
    let module = naga::front::wgsl::parse_str(&variant.source)?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module)?;
    let stage = module.entry_points.iter().find(|entry| entry.name == variant.entry).context("no such entry")?.stage;
    let constants = variant.constants.iter().map(|(name, value)| ((*name).to_owned(), f64::from(*value))).collect();
    let (module, info) = process_overrides(&module, &info, Some((stage, variant.entry)), &constants)?;
    let entry = module.entry_points.first().context("no entry is left")?;
    Ok(work_of(&module, &info, &entry.function, info.get_entry_point(0)))
}

/// Returns the shader variants that draw a package with a look.
fn variants(package: &NamedPackage<'_>, keys: &[&str]) -> anyhow::Result<Vec<ShaderVariant>> {
    let mut look = Look::default();
    for key in keys {
        look.set(key)?;
    }
    look.set("picture.size=834x424")?;
    let look = look.resolved(true);
    let cast = Cast::crowd(package, package.open()?, None, 1, None, (&Framing::default(), look.aspect()))?;
    let mut stage = Stage::new(&cast, &look.picture(), look.frame_params(), 0.0, Gpu::open)?;
    stage.draw()?;
    Ok(stage.shader_variants())
}

pub fn run() -> anyhow::Result<()> {
    std::env::set_current_dir(workspace())?;
    let folder = ChoreFolder::default();
    let baked = folder.bake("hare", &["assets/models/hare.glb", "--set", "ink.enabled=false"])?;
    let package = NamedPackage::new("hare.pelage", std::fs::read(&baked.package)?);
    let mut lines: Vec<String> =
        ["| frame | entry point | operations | special among them | texture reads |", "|---|---|---|---|---|"]
            .map(str::to_owned)
            .into();
    for (way, keys, entries) in WAYS {
        // Variants for reduced levels of detail and for the far layer do more than the others.
        let mut found: BTreeMap<(usize, &str), Vec<Work>> = BTreeMap::new();
        for variant in variants(&package, keys)? {
            if let Some(place) = entries.iter().position(|begin| variant.entry.starts_with(begin)) {
                found.entry((place, variant.entry)).or_default().push(count(&variant)?);
            }
        }
        for ((_, entry), works) in found {
            let range = |of: fn(&Work) -> u64| {
                let (least, most) = (works.iter().map(of).min(), works.iter().map(of).max());
                let [least, most] = [least, most].map(|n| n.unwrap_or_default().to_string());
                if least == most { least } else { format!("{least} to {most}") }
            };
            let [operations, special, reads] = [range(|w| w.operations), range(|w| w.special), range(|w| w.reads)];
            lines.push(format!("| {way} | `{entry}` | {operations} | {special} | {reads} |"));
        }
    }
    let when =
        format!("{}, commit {}", stdout_of("date", &["+%F"])?, stdout_of("git", &["rev-parse", "--short", "HEAD"])?);
    lines.extend([String::new(), format!("Counted in the shaders of {when}.")]);
    let path = workspace().join("runtime/docs/performance.md");
    std::fs::write(&path, replace_table(&std::fs::read_to_string(&path)?, "shaders", &lines)?)?;
    Ok(())
}
