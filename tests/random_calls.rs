//! Random calls of the C interface, in any order and state, with values no host should pass: the process lives, no
//! call is fatal, what is accepted comes back as numbers, and the same calls give the same answers.
//!
//! `GEARMESH_RANDOM_CALLS` sets the number of calls per unit and interface; 50 000 without it.

#![allow(unsafe_code)] // it calls what C calls

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;

use ::fmi::fmi2::binding::*;
use gearmesh::fmi::c_interface::*;
use gearmesh::random::Random;

#[path = "units/mod.rs"]
mod units;

/// Values beyond those that a simulation has.
const REALS: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-3,
    0.08,
    82.104,
    1e-12,
    1e12,
    -1e12,
    1e-320,
    f64::MAX,
    f64::MIN_POSITIVE,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

/// The first value references are the inputs', the next ones those of outputs; others follow, and a few beyond the
/// last one are tried, too.
const INPUTS: f64 = 48.0;
const OUTPUTS: f64 = 72.0;
const REFERENCES: f64 = 130.0;

/// One instance under random calls.
struct Host {
    component: fmi2Component,
    random: Random,
    time: f64,
    states: Vec<fmi2FMUstate>,
    bytes: Vec<fmi2Byte>,
    /// Everything that came back, in a digest.
    answers: u64,
    accepted: usize,
}

impl Host {
    fn new(uri: &CStr, kind: fmi2Type, seed: u64) -> Host {
        let guid = CString::new(units::GUID).unwrap();
        let callbacks = fmi2CallbackFunctions {
            logger: None,
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: ptr::null_mut::<c_void>(),
        };
        let [off, on] = [fmi2False as fmi2Boolean, fmi2True as fmi2Boolean];
        // Safety: all pointers are valid during the call.
        let component = unsafe {
            fmi2Instantiate(
                c"random".as_ptr(),
                kind,
                guid.as_ptr(),
                uri.as_ptr(),
                &callbacks,
                off,
                on,
            )
        };
        assert!(!component.is_null());
        Host {
            component,
            random: Random::new(seed),
            time: 0.0,
            states: vec![],
            bytes: vec![],
            answers: 0,
            accepted: 0,
        }
    }

    fn below(&mut self, count: usize) -> usize {
        (self.random.next() * count as f64) as usize
    }

    fn real(&mut self) -> f64 {
        match self.below(60) {
            0 => REALS[self.below(REALS.len())],
            // What positions, angles and speeds of the units are of.
            1..=4 => 0.08 + self.random.within([-1e-4, 1e-4]),
            5..=9 => self.random.within([-100.0, 100.0]),
            _ => self.random.within([-1e-4, 1e-4]),
        }
    }

    fn references(&mut self) -> Vec<u32> {
        let count = [1, 1, 3, 24, 48][self.below(5)];
        let most = [INPUTS, INPUTS, OUTPUTS, REFERENCES][self.below(4)];
        (0..count)
            .map(|_| match self.below(2000) {
                0 => u32::MAX,
                _ => self.random.within([0.0, most]) as u32,
            })
            .collect()
    }

    fn note(&mut self, bits: u64) {
        self.answers = (self.answers ^ bits)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(23);
    }

    /// Notes numbers that the unit gave; only those of inputs may be what no computation gives.
    fn take(&mut self, status: fmi2Status, values: &[f64]) {
        for value in values.iter().filter(|_| status <= fmi2Status_fmi2Warning) {
            assert!(value.is_finite(), "{value} with status {status}");
            self.note(value.to_bits());
        }
    }

    /// One call.
    fn call(&mut self) {
        let c = self.component;
        let vr = self.references();
        let n = vr.len();
        let orders: Vec<i32> = (0..n).map(|_| self.below(4) as i32).collect();
        let reals: Vec<f64> = (0..n).map(|_| self.real()).collect();
        let integers: Vec<i32> = (0..n).map(|_| self.below(6) as i32 - 1).collect();
        let mut numbers = vec![0.0; n];
        let mut whole = vec![0; n];
        let which = self.below(36);
        // Safety: `c` is a component that is not freed; arrays are as long as said.
        let status = unsafe {
            match which {
                0..=4 => fmi2SetReal(c, vr.as_ptr(), n, reals.as_ptr()),
                5 => fmi2SetInteger(c, vr.as_ptr(), n, integers.as_ptr()),
                6 => fmi2SetBoolean(c, vr.as_ptr(), n, integers.as_ptr()),
                7..=9 => {
                    let status = fmi2GetReal(c, vr.as_ptr(), n, numbers.as_mut_ptr());
                    self.take(status, &numbers);
                    status
                }
                10 => fmi2GetInteger(c, vr.as_ptr(), n, whole.as_mut_ptr()),
                11 => fmi2GetBoolean(c, vr.as_ptr(), n, whole.as_mut_ptr()),
                12 | 13 => {
                    let known = self.references();
                    let seed: Vec<f64> = known.iter().map(|_| self.real()).collect();
                    let [u, k] = [vr.as_ptr(), known.as_ptr()];
                    let out = numbers.as_mut_ptr();
                    let count = known.len();
                    let status =
                        fmi2GetDirectionalDerivative(c, u, n, k, count, seed.as_ptr(), out);
                    // A seed may be as large as a number can be, and so may be its product.
                    if seed.iter().all(|s| s.abs() < 1e6) {
                        self.take(status, &numbers);
                    }
                    status
                }
                14 => {
                    fmi2SetRealInputDerivatives(c, vr.as_ptr(), n, orders.as_ptr(), reals.as_ptr())
                }
                15 => {
                    let out = numbers.as_mut_ptr();
                    let status =
                        fmi2GetRealOutputDerivatives(c, vr.as_ptr(), n, orders.as_ptr(), out);
                    self.take(status, &numbers);
                    status
                }
                16..=19 => {
                    let step = [1e-5, 1e-6, 1e-3, 0.0, self.real()][self.below(5)];
                    let point = if self.below(10) == 0 {
                        self.real()
                    } else {
                        self.time
                    };
                    let status = fmi2DoStep(c, point, step, fmi2True as fmi2Boolean);
                    let mut time = 0.0;
                    let kind = fmi2StatusKind_fmi2LastSuccessfulTime;
                    if fmi2GetRealStatus(c, kind, &mut time) == fmi2Status_fmi2OK {
                        self.time = time;
                    }
                    status
                }
                20 => fmi2SetTime(c, reals[0]),
                21 => fmi2EnterContinuousTimeMode(c),
                22 => fmi2EnterEventMode(c),
                23 => {
                    let mut info = std::mem::zeroed::<fmi2EventInfo>();
                    fmi2NewDiscreteStates(c, &mut info)
                }
                24 => {
                    let [mut event, mut terminate] = [0; 2];
                    fmi2CompletedIntegratorStep(c, 1, &mut event, &mut terminate)
                }
                25 => self.keep(),
                26 => {
                    let state = self.state();
                    fmi2SetFMUstate(c, state)
                }
                27 => {
                    let state = self.state();
                    self.write(state)
                }
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
        assert!(
            status < fmi2Status_fmi2Fatal,
            "call {which}: status {status}"
        );
        self.accepted += usize::from(status == fmi2Status_fmi2OK);
        self.note(u64::from(status) << 8 | which as u64);
        for value in whole {
            self.note(value as u64);
        }
    }

    /// From wherever the instance is to a running simulation of valid poses.
    fn begin(&mut self) -> fmi2Status {
        let c = self.component;
        self.time = 0.0;
        // Safety: `c` is a component.
        unsafe {
            fmi2Reset(c);
            fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
            fmi2EnterInitializationMode(c);
            fmi2ExitInitializationMode(c)
        }
    }

    /// A state that is kept, was freed, or never was.
    fn state(&mut self) -> fmi2FMUstate {
        match self.states.len() {
            0 => ptr::null_mut(),
            _ if self.below(10) == 0 => ptr::without_provenance_mut(usize::MAX - self.below(1000)),
            count => {
                let place = self.below(count);
                self.states[place]
            }
        }
    }

    fn keep(&mut self) -> fmi2Status {
        let mut state = self.state();
        // Safety: `state` is a place for a state.
        let status = unsafe { fmi2GetFMUstate(self.component, &mut state) };
        self.states.push(state);
        if self.states.len() > 20 {
            let mut first = self.states.remove(0);
            // Safety: as above; the same handle may stand in the list twice.
            unsafe { fmi2FreeFMUstate(self.component, &mut first) };
        }
        status
    }

    fn write(&mut self, state: fmi2FMUstate) -> fmi2Status {
        let mut size = 0;
        // Safety: the array is as long as said.
        unsafe {
            let status = fmi2SerializedFMUstateSize(self.component, state, &mut size);
            if status != fmi2Status_fmi2OK {
                return status;
            }
            self.bytes = vec![0; size];
            let bytes = self.bytes.as_mut_ptr();
            fmi2SerializeFMUstate(self.component, state, bytes, size)
        }
    }

    /// Reads the last bytes, often with one of them changed or some cut off.
    fn read(&mut self) -> fmi2Status {
        let mut bytes = self.bytes.clone();
        if !bytes.is_empty() {
            let place = self.below(bytes.len());
            match self.below(4) {
                0 => bytes[place] = self.below(256) as u8 as fmi2Byte,
                1 => bytes.truncate(place),
                _ => {}
            }
        }
        let mut state = ptr::null_mut();
        let data = bytes.as_ptr();
        // Safety: the array is as long as said.
        let status =
            unsafe { fmi2DeSerializeFMUstate(self.component, data, bytes.len(), &mut state) };
        if status == fmi2Status_fmi2OK {
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

fn run(uri: &CStr, kind: fmi2Type, seed: u64, calls: usize) -> (u64, usize) {
    let mut host = Host::new(uri, kind, seed);
    host.begin();
    for _ in 0..calls {
        host.call();
    }
    (host.answers, host.accepted)
}

#[test]
fn random_calls_end_in_answers_or_refusals_and_the_same_ones_twice() {
    let calls = std::env::var("GEARMESH_RANDOM_CALLS");
    let calls = calls.map_or(50_000, |text| text.parse().expect("a number of calls"));
    let constant = tempfile::tempdir().unwrap();
    let tables = tempfile::tempdir().unwrap();
    let uris = [
        units::resources(constant.path(), &units::spur()),
        units::resources(tables.path(), &units::tabulated(tables.path())),
    ];
    for (number, uri) in uris.iter().enumerate() {
        for kind in [fmi2Type_fmi2CoSimulation, fmi2Type_fmi2ModelExchange] {
            let seed = 0x9e37_79b9_7f4a_7c15 + 2 * number as u64 + u64::from(kind);
            let once = run(uri, kind, seed, calls);
            assert!(once.1 > calls / 20, "only {} calls were accepted", once.1);
            assert_eq!(once, run(uri, kind, seed, calls));
            println!(
                "unit {number}, interface {kind}: {} of {calls} accepted",
                once.1
            );
        }
    }
}
