use super::*;
use crate::subject::Subject;
use pelage_stage::{Look, NamedPackage, Viewpoint};
use std::path::Path;
use std::sync::mpsc::RecvTimeoutError;

const SECOND: Duration = Duration::from_secs(10);

/// Workshop with a single file, whose packages contain the edits with which they were made. It reports the start of
/// each, and waits for permission to continue.
struct TestWorkshop {
    file: PathBuf,
    begins: Sender<Vec<String>>,
    go_on: Receiver<()>,
}

impl Workshop for TestWorkshop {
    fn open(&mut self, path: &Path) -> Outcome<()> {
        if path.exists() { Ok(()) } else { Err(format!("{}: there is no such file", path.display())) }
    }

    fn make(&mut self, edits: &[String], _: &mut dyn FnMut(Progress)) -> Outcome<WindowContent> {
        assert!(edits != ["a.b=panic"], "this test panics on purpose");
        self.begins.send(edits.to_vec()).unwrap();
        self.go_on.recv().unwrap();
        let subject = Subject::Package(Arc::new(NamedPackage::new("a", edits.join(" ").into_bytes())));
        Ok(WindowContent { subject, look: None, recipe: None, notes: Vec::new(), stages: Vec::new() })
    }

    fn files(&self) -> Vec<PathBuf> {
        vec![self.file.clone()]
    }

    fn save_recipe(&mut self, edits: &[String]) -> Outcome<PathBuf> {
        if edits.is_empty() { Err("nothing to save".into()) } else { Ok(self.file.clone()) }
    }

    fn reference_source(&self) -> Box<dyn ReferenceSource> {
        Box::new(EndlessTracer)
    }
}

/// Reference source that traces until it is cancelled.
struct EndlessTracer;

impl ReferenceSource for EndlessTracer {
    fn trace(
        &mut self,
        asked: &ReferenceRequest,
        show: &mut dyn FnMut(ReferencePicture),
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Outcome<()> {
        let picture = image::RgbaImage::new(1, 1);
        show(ReferencePicture { picture, samples: asked.time_s as u32, of_samples: 64, flip: None });
        while progress(Progress::default()).is_continue() {
            std::thread::sleep(Duration::from_millis(1));
        }
        Err("cancelled".into())
    }
}

struct Bench {
    workers: Workers,
    told: Receiver<WorkerMessage>,
    begins: Receiver<Vec<String>>,
    go_on: Sender<()>,
    _folder: tempfile::TempDir,
    file: PathBuf,
}

fn bench() -> Bench {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.toml");
    std::fs::write(&file, "1").unwrap();
    let (tell, told) = channel();
    let (begin, begins) = channel();
    let (go_on, going_on) = channel();
    let shop = TestWorkshop { file: file.clone(), begins: begin, go_on: going_on };
    let tell = Mutex::new(tell);
    let tell: SendMessage = Arc::new(move |message| tell.lock().unwrap().send(message).unwrap_or_default());
    Bench { workers: Workers::start(Box::new(shop), &tell), told, begins, go_on, _folder: folder, file }
}

impl Bench {
    /// Returns the content that is made next, or the error.
    fn made(&self) -> Result<String, String> {
        loop {
            match self.told.recv_timeout(SECOND).unwrap() {
                WorkerMessage::Made(made, _) => {
                    return Ok(String::from_utf8(made.subject.packages()[0].bytes.to_vec()).unwrap());
                }
                WorkerMessage::Failed(reason) => return Err(reason),
                _ => {}
            }
        }
    }

    fn begun(&self) -> Vec<String> {
        self.begins.recv_timeout(SECOND).unwrap()
    }
}

#[test]
fn only_the_last_of_many_changes_is_made() {
    let bench = bench();
    bench.workers.open(bench.file.clone());
    assert_eq!(bench.begun(), [""; 0]);
    for value in 1..20 {
        bench.workers.make(vec![format!("a.b={value}")]);
    }
    bench.go_on.send(()).unwrap();
    assert_eq!(bench.made().unwrap(), "");
    assert_eq!(bench.begun(), ["a.b=19"]);
    bench.go_on.send(()).unwrap();
    assert_eq!(bench.made().unwrap(), "a.b=19");
    assert_eq!(bench.begins.recv_timeout(Duration::from_millis(50)), Err(RecvTimeoutError::Timeout));
}

#[test]
fn changed_file_is_rebuilt_with_the_unsaved_edits() {
    let bench = bench();
    (0..5).for_each(|_| bench.go_on.send(()).unwrap());
    bench.workers.open(bench.file.clone());
    bench.made().unwrap();
    bench.workers.make(vec!["a.b=1".into()]);
    assert_eq!(bench.made().unwrap(), "a.b=1");
    std::fs::write(&bench.file, "22").unwrap();
    assert_eq!(bench.made().unwrap(), "a.b=1");
    bench.workers.save(vec!["a.b=1".into()]);
    assert_eq!(bench.made().unwrap(), "", "the file must contain the edit now");
    bench.workers.open("no/such.pelage".into());
    assert!(bench.made().unwrap_err().contains("no/such.pelage"));
}

#[test]
fn worker_survives_and_reports_a_panic() {
    let bench = bench();
    (0..2).for_each(|_| bench.go_on.send(()).unwrap());
    bench.workers.open(bench.file.clone());
    bench.made().unwrap();
    bench.workers.make(vec!["a.b=panic".into()]);
    assert!(bench.made().unwrap_err().contains("internal error in pelage"));
    bench.workers.make(vec!["a.b=1".into()]);
    assert_eq!(bench.made().unwrap(), "a.b=1");
}

#[test]
fn new_reference_request_cancels_the_previous_one() {
    let bench = bench();
    let asked = |time_s| ReferenceRequest {
        file: Arc::new(NamedPackage::new("a", Vec::new())),
        look: Look::default(),
        camera: Viewpoint { eye: glam::Vec3::Z, target: glam::Vec3::ZERO, fov_deg: 30.0 },
        clip: None,
        time_s,
        drawn: image::RgbaImage::new(1, 1),
    };
    let samples = || loop {
        match bench.told.recv_timeout(SECOND).unwrap() {
            WorkerMessage::Truth(truth) => return truth.samples,
            WorkerMessage::NoTruth(_) => return 0,
            _ => {}
        }
    };
    bench.workers.trace(asked(1.0));
    assert_eq!(samples(), 1);
    bench.workers.trace(asked(2.0));
    let after = [samples(), samples()];
    assert!(after.contains(&2), "{after:?}");
}
