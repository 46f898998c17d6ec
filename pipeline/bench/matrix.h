// SPDX-License-Identifier: MIT
// Matrix throughput: vertices by one composite and by seven matrices, products of chains, each way next to the memory's bandwidth.
#pragma once

#include "host/recorder.h"
#include "pipeline/bench/statistics.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace plumb {

struct MatrixWay {
    std::string name;  // "device, one composite"
    Spread ms;
    double perSecond = 0;     // vertices, or matrices of the chain; from the median
    double shareOfBound = 0;  // share of the rate that the memory's bandwidth allows
    Spread ofDevice;    // ways on the device: time of the table's ceiling (below) / this time, of each round; count 0: not on the device
    Spread againstGlm;  // GLM's best time / this time, of each round; above 1: faster than GLM
    uint64_t products = 0;  // products of two matrices, or of a matrix and a vertex
    uint64_t steps = 0;     // longest chain of products in which each needs the one before it
    bool partial = false;   // only stores or loads, with a kernel of the same shape: no result, no error, nothing against GLM
    double errorU = 0;      // largest error of a result against the product in long double, in units of 2^-24 of the result's largest entry
};

struct MatrixTable {
    std::string work;  // "vertices" or "chain"
    uint64_t count = 0;
    double bytesEach = 0;     // bytes that must cross the memory for one item; the bound follows from them
    double bandwidthGBs = 0;  // measured in the same rounds, on arrays of the same size
    std::string
        ceiling;  // the partial way that a way on the device is held against: loads and stores what the work needs, and nothing else
    std::vector<MatrixWay> ways;
    std::vector<std::string> absent;  // ways that were not measured, and why
    std::string failure;              // difference of device and twin; empty: none
};

struct MatrixOptions {
    uint32_t rounds = 50;
    uint32_t threads = 0;  // threads of ways on the processor; 0: all
    double watchdogMs = 60000;
    std::function<void(double)> onProgress;
};

// Benches `count` >= 1 items. No upload is within a time. Vertices: all ways read and write the same two arrays, so that each finds in the
// caches what the way before left. Chains: two arrays of equal size, larger than the caches where that matters, since libraries keep
// columns where the device reads rows.
MatrixTable benchVertices(Device& device, uint64_t count, const MatrixOptions& options);
MatrixTable benchChain(Device& device, uint64_t count, const MatrixOptions& options);

}  // namespace plumb
