//! Stored states: refused, or a unit that goes on from there with numbers, or refuses to.
//!
//! An input is the JSON inside a state. Version and checksum are put around it, since whoever means harm can do that,
//! too; and it is read as it stands.

use std::sync::{Arc, LazyLock};

use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::{Function, Interface};
use gearmesh::fmi::resources::Resources;
use gearmesh::fmi::variables::{Kind, VARIABLES, index};
use gearmesh::sealed;

use super::unit_file::{INTERFACES, outputs, unit};
use super::{Target, change, tables};

/// States in the middle of a simulation through both interfaces are where it starts.
pub const TARGET: Target = Target {
    seeds: || {
        INTERFACES
            .map(|interface| inside(&state(interface)).to_vec())
            .to_vec()
    },
    change: change::json,
    check,
};

/// A unit with everything that a table may hold.
static RESOURCES: LazyLock<Arc<Resources>> = LazyLock::new(|| {
    let file = tables::formula([8, 4, 4, 6]);
    let geometry = file.geometry.clone();
    let starts = [
        ("stiffnessModel", 2.0),
        ("friction", 1.0),
        ("rootStress", 1.0),
    ];
    let unit = unit("spring", geometry, &starts);
    Arc::new(Resources::new(unit, Some(file), None).expect("a unit by hand"))
});

fn instance(interface: Interface) -> Instance {
    Instance::new(Arc::clone(&RESOURCES), interface)
}

/// The state of an instance in contact, after a step.
fn state(interface: Interface) -> Vec<u8> {
    let mut instance = instance(interface);
    instance.setup(0.125, None).expect("a start time");
    let inputs = [index::GEAR1_ANGLES_3, index::GEAR2_ANGULAR_VELOCITY_3];
    let references = inputs.map(|i| VARIABLES[i].value_reference);
    instance
        .set(Kind::Real, &references, &[1e-4, -0.1])
        .expect("inputs");
    if interface == Interface::CoSimulation {
        let set = instance.set_input_derivatives(&references[..1], &[1], &[0.7]);
        set.expect("a rate");
    }
    instance.exit_initialization().expect("the start pose");
    if interface == Interface::CoSimulation {
        instance.do_step(0.125, 1e-5).expect("a step");
    }
    let handle = instance.store(None).expect("a state");
    instance.serialize(handle).expect("its bytes")
}

/// The JSON inside a state.
fn inside(state: &[u8]) -> &[u8] {
    &state[sealed::HEAD..]
}

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    static MAGIC: LazyLock<[u8; 32]> = LazyLock::new(|| {
        let state = state(Interface::CoSimulation);
        *state.first_chunk().expect("a head")
    });
    let sealed = sealed::seal(&MAGIC, data);
    let each = INTERFACES.map(|interface| {
        let is_state = [data, &sealed].map(|bytes| go_on(instance(interface), bytes));
        is_state.contains(&true)
    });
    each.contains(&true)
}

/// Goes to the state and on from there; false if it is refused.
fn go_on(mut instance: Instance, bytes: &[u8]) -> bool {
    let handle = match instance.deserialize(bytes) {
        Ok(handle) => handle,
        Err(refusal) => {
            assert!(!refusal.message.is_empty());
            return false;
        }
    };
    if instance.restore(handle).is_err() {
        return false;
    }
    // Stored again it is the same state, but for the sign of a whole number's zero.
    let again = instance.store(None).expect("the state just entered");
    let [once, twice] = [handle, again].map(|h| {
        let bytes = instance.serialize(h).expect("a stored state");
        serde_json::from_slice::<serde_json::Value>(inside(&bytes)).expect("JSON")
    });
    assert_eq!(once, twice, "the state changed when it was entered");
    outputs(&mut instance);
    for _ in 0..2 {
        if instance.admit(Function::fmi2DoStep).is_err()
            || instance.do_step(instance.time(), 1e-5).is_err()
        {
            break;
        }
        outputs(&mut instance);
    }
    // Nothing of it stays after a reset.
    if instance.admit(Function::fmi2Reset).is_ok() {
        instance.reset();
        instance.exit_initialization().expect("the start pose");
        outputs(&mut instance);
    }
    true
}
