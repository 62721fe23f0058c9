//! Thread that holds a model and bakes it on request. Only stages whose inputs have changed are recomputed.

use crate::stage_times::StageTimes;
use pelage_bake::pipeline::{BakeInput, Baked, STEPS, StepEvent};
use pelage_bake::progress::StageProgress;
use pelage_bake::rebake::Rebake;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use pelage_viewer::Progress;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;
use typed_arena::Arena;

/// Polling interval of the progress of a long stage.
const ASKED_EVERY: Duration = Duration::from_millis(100);

/// Number of recipes after which the baked data and the recipes that they borrow are freed. The next bake is a whole
/// one.
const MOST_RECIPES: usize = 256;

struct BakeRequest {
    recipe: Recipe,
    /// Images of the recipe; `None` reuses those of the previous request.
    images: Option<MapImages>,
}

enum Answer {
    Step(StepEvent),
    Done(Box<Result<Baked, BakeError>>),
}

/// Finished bake, and the duration of each stage that ran, seconds.
pub type Timed = (Baked, Vec<(String, f64)>);

/// Handle of the bake thread. Dropping it ends the thread.
pub struct BakeThread {
    orders: Sender<BakeRequest>,
    answers: Receiver<Answer>,
    steps: Arc<StageProgress>,
}

impl BakeThread {
    /// Starts the thread with an imported model, its file and its name.
    pub fn new(file: String, name: String, model: Model) -> Self {
        let (orders, ordered) = channel();
        let (answer, answers) = channel();
        let steps = Arc::new(StageProgress::new());
        let counted = steps.clone();
        std::thread::spawn(move || bake_all(&file, &name, &model, &counted, &ordered, &answer));
        Self { orders, answers, steps }
    }

    /// Bakes the model with a recipe and images. `None` reuses the images of the previous bake.
    ///
    /// Fails with errors of the bake; [`BakeError::Internal`] if the thread has ended.
    pub fn bake(
        &self,
        recipe: Recipe,
        images: Option<MapImages>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Timed, BakeError> {
        let gone = || BakeError::Internal("the baking thread has ended".into());
        self.orders.send(BakeRequest { recipe, images }).map_err(|_| gone())?;
        let (mut times, mut share, mut shown) = (StageTimes::default(), 0.0f32, 0.0f32);
        loop {
            match self.answers.recv_timeout(ASKED_EVERY) {
                Ok(Answer::Step(event)) => {
                    times.on_event(event);
                    if let StepEvent::Ends(step) = event {
                        let place = STEPS.iter().position(|known| known.makes == step.makes).unwrap_or(0);
                        share = share.max((place + 1) as f32 / STEPS.len() as f32);
                    }
                }
                Ok(Answer::Done(baked)) => {
                    let seconds = times.finish().into_iter().map(|stage| (stage.name.to_owned(), stage.seconds));
                    return Ok(((*baked)?, seconds.collect()));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            }
            let running = times.running();
            if !running.is_empty() {
                let part = self.steps.get().map_or(0.0, |count| count.done as f32 / count.total as f32);
                shown = shown.max(share + part / STEPS.len() as f32).min(1.0);
                progress(Progress { doing: running.join(", "), share: Some(shown) });
            }
        }
    }
}

fn bake_all(
    file: &str,
    name: &str,
    model: &Model,
    steps: &StageProgress,
    orders: &Receiver<BakeRequest>,
    answer: &Sender<Answer>,
) {
    let Ok(mut order) = orders.recv() else { return };
    let mut images = MapImages::default();
    loop {
        if let Some(others) = order.images.take() {
            images = others;
        }
        // Baked data borrow their recipe and images, so all of them are freed together.
        let recipes = Arena::new();
        let mut rebake = Rebake::new(model);
        order = loop {
            let told =
                BakeInput { progress: steps, ..BakeInput::new(file, name, recipes.alloc(order.recipe), &images) };
            // The requester may be gone, in which case the progress report is dropped.
            let baked = rebake.bake(&told, &mut |event| drop(answer.send(Answer::Step(event))));
            if answer.send(Answer::Done(Box::new(baked))).is_err() {
                return;
            }
            let Ok(next) = orders.recv() else { return };
            order = next;
            if order.images.is_some() || recipes.len() >= MOST_RECIPES {
                break order;
            }
        };
    }
}
