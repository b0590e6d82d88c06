#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pellicle_fuzz::frame(bytes));
