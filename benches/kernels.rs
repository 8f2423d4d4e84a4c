//! Every kernel at every instruction-set level, on one thread and in cache.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use spheremap::Map;
use spheremap::projections::REGISTRY;
use spheremap::{simd, threads};
use std::hint::black_box;

const N: usize = 4096;

fn kernels(criterion: &mut Criterion) {
    threads::set_count(1);
    let directions: Vec<f32> = (0..3 * N)
        .map(|i| ((i * 7919 % 2003) as f32 - 1001.0) / 1001.0)
        .collect();
    for info in REGISTRY {
        let map = Map::new(info.name).expect("registered");
        let mut uv = vec![0.0_f32; N * map.uv_width()];
        let mut back = vec![0.0_f32; 3 * N];
        let mut group = criterion.benchmark_group(info.name);
        group.throughput(Throughput::Elements(N as u64));
        for level in simd::levels() {
            assert!(simd::force_level(Some(level)));
            group.bench_function(format!("encode f32 {level}"), |b| {
                b.iter(|| map.encode(black_box(&directions), black_box(&mut uv[..])));
            });
            group.bench_function(format!("decode f32 {level}"), |b| {
                b.iter(|| map.decode(black_box(&uv), black_box(&mut back[..])));
            });
        }
        simd::force_level(None);
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
