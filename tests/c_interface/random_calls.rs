//! Random calls of the C interface, in any order and state, with values no host should pass: the process lives, no
//! call is fatal, what is accepted comes back as numbers, and the same calls give the same answers.
//!
//! `GEARMESH_RANDOM_CALLS` sets the number of calls per FMU and interface; 50 000 without it.

use super::*;
use gearmesh::fmi::variables::{Causality, Kind, VARIABLES, index};
use gearmesh::random::Random;
use std::ffi::c_char;

/// Values beyond those that a simulation has.
const REALS: [f64; 16] = {
    const INFINITY: f64 = f64::INFINITY;
    const MAX: f64 = f64::MAX;
    const NAN: f64 = f64::NAN;
    [
        0.0, -0.0, 1.0, -1.0, 1e-3, 0.08, 82.104, 1e-12, 1e12, -1e12, 1e-320, 2.3e-308, MAX, NAN,
        INFINITY, -INFINITY,
    ]
};

/// Value references of inputs, outputs and parameters, each with a few beyond the last one.
const INPUTS: [f64; 2] = [0.0, 49.0];
const OUTPUTS: [f64; 2] = [100.0, 132.0];
const PARAMETERS: [f64; 2] = [200.0, 226.0];

/// One instance under random calls.
struct Host {
    component: fmi2Component,
    random: Random,
    time: f64,
    states: Vec<fmi2FMUstate>,
    bytes: Vec<fmi2Byte>,
    /// Everything that came back, in a digest.
    answers: u64,
    accepted: Accepted,
}

/// Calls that the FMU accepted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Accepted {
    calls: usize,
    /// Parameters set.
    parameters: usize,
    /// Outputs read.
    outputs: usize,
    /// Simulations begun, by `stiffnessModel`.
    begun: [usize; 4],
    /// States restored.
    restored: usize,
}

impl Host {
    fn new(uri: &CStr, kind: fmi2Type, seed: u64) -> Host {
        let guid = CString::new(GUID).unwrap();
        let (guid, uri) = (guid.as_ptr(), uri.as_ptr());
        // Safety: all pointers are valid during the call.
        let component =
            unsafe { fmi2Instantiate(c"random".as_ptr(), kind, guid, uri, ptr::null(), 0, 1) };
        assert!(!component.is_null());
        Host {
            component,
            random: Random::new(seed),
            time: 0.0,
            states: vec![],
            bytes: vec![],
            answers: 0,
            accepted: Accepted::default(),
        }
    }

    fn below(&mut self, count: usize) -> usize {
        (self.random.next() * count as f64) as usize
    }

    fn real(&mut self) -> f64 {
        match self.below(60) {
            0 => REALS[self.below(REALS.len())],
            // What positions, angles and speeds of the FMUs are of.
            1..=4 => 0.08 + self.random.within([-1e-4, 1e-4]),
            5..=9 => self.random.within([-100.0, 100.0]),
            _ => self.random.within([-1e-4, 1e-4]),
        }
    }

    /// Of one causality, or one and those that follow.
    fn references(&mut self) -> Vec<u32> {
        let count = [1, 1, 3, 24, 48][self.below(5)];
        let range = [INPUTS, INPUTS, OUTPUTS, PARAMETERS][self.below(4)];
        let first = self.random.within(range) as u32;
        let is_block = self.below(2) == 0;
        let one = |k| match self.below(2000) {
            0 => u32::MAX,
            _ if is_block => first + k,
            _ => self.random.within(range) as u32,
        };
        (0..count).map(one).collect()
    }

    /// Sets parameters of any type, most of them one by one, before a simulation begins.
    fn choose(&mut self) {
        let c = self.component;
        let kinds = VARIABLES
            .iter()
            .filter(|v| v.causality == Causality::Parameter);
        let kinds: Vec<_> = kinds.map(|v| (v.value_reference, v.kind)).collect();
        for _ in 0..self.below(6) {
            let (vr, kind) = kinds[self.below(kinds.len())];
            let (real, whole) = (self.real().abs(), self.below(5) as i32);
            // Safety: `c` is a component; arrays have one item.
            let status = unsafe {
                match kind {
                    Kind::Real => fmi2SetReal(c, &vr, 1, &real),
                    Kind::Boolean => fmi2SetBoolean(c, &vr, 1, &whole.min(1)),
                    _ => fmi2SetInteger(c, &vr, 1, &whole),
                }
            };
            if status != fmi2OK {
                return;
            }
            self.accepted.parameters += 1;
        }
    }

    fn note(&mut self, bits: u64) {
        self.answers = (self.answers ^ bits)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(23);
    }

    /// Notes numbers that the FMU gave; only those of inputs may be what no computation gives.
    fn take(&mut self, status: fmi2Status, values: &[f64]) {
        for value in values.iter().filter(|_| status <= fmi2Warning) {
            assert!(value.is_finite(), "{value} with status {status}");
            self.note(value.to_bits());
        }
    }

    /// One call.
    fn call(&mut self) {
        let c = self.component;
        let (references, known) = (self.references(), self.references());
        let (n, vr) = (references.len(), references.as_ptr());
        let orders: Vec<i32> = (0..n).map(|_| self.below(4) as i32).collect();
        let reals: Vec<f64> = (0..n).map(|_| self.real()).collect();
        let integers: Vec<i32> = (0..n).map(|_| self.below(6) as i32 - 1).collect();
        let seed: Vec<f64> = known.iter().map(|_| self.real()).collect();
        let (mut numbers, mut whole) = (vec![0.0; n], vec![0; n]);
        let (out, flags) = (numbers.as_mut_ptr(), whole.as_mut_ptr());
        let (real, integer, order) = (reals.as_ptr(), integers.as_ptr(), orders.as_ptr());
        let which = self.below(36);
        // Safety: `c` is a component that is not freed; arrays are as long as said.
        let status = unsafe {
            match which {
                0..=4 => fmi2SetReal(c, vr, n, real),
                5 => fmi2SetInteger(c, vr, n, integer),
                6 => fmi2SetBoolean(c, vr, n, integer),
                7..=9 => {
                    let status = fmi2GetReal(c, vr, n, out);
                    let outputs = (100..200).contains(&references[0]) && status == fmi2OK;
                    self.accepted.outputs += usize::from(outputs);
                    status
                }
                10 => fmi2GetInteger(c, vr, n, flags),
                11 => fmi2GetBoolean(c, vr, n, flags),
                12 | 13 => {
                    let (by, count) = (known.as_ptr(), known.len());
                    fmi2GetDirectionalDerivative(c, vr, n, by, count, seed.as_ptr(), out)
                }
                14 => fmi2SetRealInputDerivatives(c, vr, n, order, real),
                15 => fmi2GetRealOutputDerivatives(c, vr, n, order, out),
                16..=19 => {
                    let step = [1e-5, 1e-6, 1e-3, 0.0, self.real()][self.below(5)];
                    let point = match self.below(10) {
                        0 => self.real(),
                        _ => self.time,
                    };
                    let status = fmi2DoStep(c, point, step, 1);
                    let mut time = 0.0;
                    let kind = fmi2LastSuccessfulTime;
                    if fmi2GetRealStatus(c, kind, &mut time) == fmi2OK {
                        self.time = time;
                    }
                    status
                }
                20 => fmi2SetTime(c, reals[0]),
                21 => fmi2EnterContinuousTimeMode(c),
                22 => fmi2EnterEventMode(c),
                23 => fmi2NewDiscreteStates(c, &mut fmi2EventInfo::default()),
                24 => fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0),
                25 => self.store(),
                26 => {
                    let status = fmi2SetFMUstate(c, self.state());
                    self.accepted.restored += usize::from(status == fmi2OK);
                    status
                }
                27 => self.write(),
                28 => self.read(),
                29 => fmi2SetDebugLogging(c, integers[0], 0, ptr::null::<*const c_char>()),
                30 => fmi2SetupExperiment(c, 0, 0.0, reals[0], integers[0], reals[n - 1]),
                31 => fmi2EnterInitializationMode(c),
                32 => fmi2ExitInitializationMode(c),
                _ => match self.below(4) {
                    0 => fmi2Terminate(c),
                    _ => self.begin(),
                },
            }
        };
        assert!(status < fmi2Fatal, "call {which}: status {status}");
        self.accepted.calls += usize::from(status == fmi2OK);
        self.note(u64::from(status) << 8 | which as u64);
        // A seed may be as large as a number can be, and so may be its product.
        if !(12..=13).contains(&which) || seed.iter().all(|s| s.abs() < 1e6) {
            self.take(status, &numbers);
        }
        for value in whole {
            self.note(value as u64);
        }
    }

    /// From wherever the instance is to a running simulation of valid poses, most often at the FMU's defaults or at another
    /// level of detail, at times with parameters of all kinds.
    fn begin(&mut self) -> fmi2Status {
        let c = self.component;
        self.time = 0.0;
        let model = VARIABLES[index::STIFFNESS_MODEL].value_reference;
        let mut level = 1 + self.below(4) as i32;
        let chosen = self.below(3);
        // Safety: `c` is a component; arrays have one item.
        unsafe {
            fmi2Reset(c);
            fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
            if chosen > 0 {
                fmi2SetInteger(c, &model, 1, &level);
            }
            if chosen > 1 {
                self.choose();
            }
            fmi2EnterInitializationMode(c);
            fmi2GetInteger(c, &model, 1, &mut level);
            let status = fmi2ExitInitializationMode(c);
            if status == fmi2OK {
                self.accepted.begun[level as usize - 1] += 1;
            }
            status
        }
    }

    /// A state that is stored, was freed, or never was.
    fn state(&mut self) -> fmi2FMUstate {
        if self.states.is_empty() {
            return ptr::null_mut();
        }
        if self.below(10) == 0 {
            return ptr::without_provenance_mut(usize::MAX - self.below(1000));
        }
        let i = self.below(self.states.len());
        self.states[i]
    }

    fn store(&mut self) -> fmi2Status {
        let mut state = self.state();
        // Safety: `state` is a place for a state; the same handle may stand in the list twice.
        unsafe {
            let status = fmi2GetFMUstate(self.component, &mut state);
            self.states.push(state);
            if self.states.len() > 20 {
                let mut first = self.states.remove(0);
                fmi2FreeFMUstate(self.component, &mut first);
            }
            status
        }
    }

    fn write(&mut self) -> fmi2Status {
        let (c, state, mut size) = (self.component, self.state(), 0);
        // Safety: the array is as long as passed.
        unsafe {
            let status = fmi2SerializedFMUstateSize(c, state, &mut size);
            if status != fmi2OK {
                return status;
            }
            self.bytes = vec![0; size];
            fmi2SerializeFMUstate(c, state, self.bytes.as_mut_ptr(), size)
        }
    }

    /// Reads the last bytes, often with one of them changed or some cut off.
    fn read(&mut self) -> fmi2Status {
        let mut bytes = self.bytes.clone();
        if !bytes.is_empty() {
            let i = self.below(bytes.len());
            match self.below(4) {
                0 => bytes[i] = self.below(256) as u8 as fmi2Byte,
                1 => bytes.truncate(i),
                _ => {}
            }
        }
        let mut state = ptr::null_mut();
        let data = bytes.as_ptr();
        // Safety: the array is as long as said.
        let status =
            unsafe { fmi2DeSerializeFMUstate(self.component, data, bytes.len(), &mut state) };
        if status == fmi2OK {
            self.states.push(state);
        }
        status
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // Safety: freed once.
        unsafe { fmi2FreeInstance(self.component) };
    }
}

fn run(uri: &CStr, kind: fmi2Type, seed: u64, calls: usize) -> (u64, Accepted) {
    let mut host = Host::new(uri, kind, seed);
    host.begin();
    for _ in 0..calls {
        host.call();
    }
    (host.answers, host.accepted)
}

/// The paper's pair with all that an FMU may hold, made on coarse finite elements by the command, unpacked into `folder`.
fn complete(folder: &Path) -> UnitFile {
    let fmu = folder.join("all.fmu");
    let root = env!("CARGO_MANIFEST_DIR");
    let program = std::env::current_exe().unwrap();
    let program = program.ancestors().nth(2).unwrap().join("gearmesh");
    let path = program.display();
    assert!(program.exists(), "no {path}: build the workspace first");
    let options = "--refinement coarse --stations 6 --no-center-distance --friction --root-stress --teeth --contact -q";
    let output = std::process::Command::new(program)
        .args(["build", &format!("{root}/resources/pairs/palermo2013.json")])
        .args(options.split(' '))
        .args(["--cache-dir", &format!("{root}/target/tmp/elastic-models")])
        .args(["-o".as_ref(), fmu.as_os_str()])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let packed = gearmesh_preprocessor::package::inspect(&fmu).unwrap();
    std::fs::write(folder.join("tables.json"), packed.tables.unwrap()).unwrap();
    let contact = packed.contact.unwrap().to_bytes();
    std::fs::write(folder.join("contact.bin"), contact).unwrap();
    UnitFile {
        guid: GUID.into(),
        ..packed.unit
    }
}

#[test]
fn random_calls_end_in_answers_or_refusals_and_the_same_ones_twice() {
    let calls = std::env::var("GEARMESH_RANDOM_CALLS");
    let calls = calls.map_or(50_000, |text| text.parse().expect("a number of calls"));
    let folders = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let [constant, tables, full] = folders.each_ref().map(|folder| folder.path());
    let uris = [
        (resources(constant, &spur()), 1..2),
        (resources(tables, &tabulated(tables)), 1..3),
        (resources(full, &complete(full)), 1..5),
    ];
    for (number, (uri, levels)) in uris.iter().enumerate() {
        for kind in [fmi2CoSimulation, fmi2ModelExchange] {
            let seed = 0x9e37_79b9_7f4a_7c15 + 2 * number as u64 + u64::from(kind);
            let once = run(uri, kind, seed, calls);
            let accepted = once.1;
            println!("unit {number}, interface {kind}, of {calls}: {accepted:?}");
            assert!(accepted.calls > calls / 20, "{accepted:?}");
            let counts = [accepted.parameters, accepted.outputs, accepted.restored];
            let often = counts.iter().all(|n| *n > calls / 500);
            assert!(often, "{accepted:?}");
            for (level, begun) in (1..).zip(accepted.begun) {
                let often = begun > calls / 2000;
                assert_eq!(often, levels.contains(&level), "{accepted:?}");
            }
            assert_eq!(once, run(uri, kind, seed, calls));
        }
    }
}
