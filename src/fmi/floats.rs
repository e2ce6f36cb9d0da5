//! The floating-point mode while a function of the C interface runs.
#![allow(unsafe_code)]

/// The floating-point mode that compiled Rust takes for granted: round to nearest, subnormal numbers, no traps. A host may run in
/// another one, with traps where it looks for its own divisions by zero, say; it gets its own back when this is dropped.
pub(super) struct DefaultFloats {
    /// Control and status register of the host (MXCSR; Intel 64 manual, volume 1, section 10.2.3).
    #[cfg(target_arch = "x86_64")]
    host: u32,
}

#[cfg(target_arch = "x86_64")]
impl DefaultFloats {
    const DEFAULT: u32 = 0x1f80;
    /// Flags of what has happened: no part of the mode.
    const FLAGS: u32 = 0x3f;

    #[inline]
    pub fn set() -> Self {
        let mut host = 0_u32;
        // Safety: writes the register to `host`.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut host, options(nostack, preserves_flags));
        }
        let own = Self { host };
        if own.differs() {
            Self::load(Self::DEFAULT);
        }
        own
    }

    fn differs(&self) -> bool {
        self.host & !Self::FLAGS != Self::DEFAULT
    }

    fn load(register: u32) {
        // Safety: reads the register from `register`, a valid value: the default one, or what the processor gave.
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack, preserves_flags, readonly));
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Drop for DefaultFloats {
    #[inline]
    fn drop(&mut self) {
        if self.differs() {
            Self::load(self.host);
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl DefaultFloats {
    pub fn set() -> Self {
        Self {}
    }
}
