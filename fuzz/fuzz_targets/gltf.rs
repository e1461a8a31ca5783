#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| shotline_io::fuzz::run("gltf", data));
