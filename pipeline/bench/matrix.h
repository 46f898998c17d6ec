// SPDX-License-Identifier: MIT
// Matrix throughput: vertices by one composite and by seven matrices, products of chains, each way beside the memory's bandwidth.
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
    double perSecond = 0;     // vertices, or matrices of the chain, by the median
    double shareOfBound = 0;  // of what the memory's bandwidth allows
    Spread ofDevice;          // of ways on the device: time of the table's ceiling (below) / this time, of each round; count 0: another's
    Spread againstGlm;        // GLM's best time / this time, of each round; above 1: faster than GLM
    uint64_t products = 0;    // of two matrices, or of a matrix and a vertex
    uint64_t steps = 0;       // of these, the longest row in which each needs the one before it
    bool partial = false;     // only stores or loads, with a kernel of the same shape: no result, no error, nothing against GLM
    double errorU = 0;  // largest error of a result against the product in long double, in units of 2^-24 of the result's largest entry
};

struct MatrixTable {
    std::string work;  // "vertices" or "chain"
    uint64_t count = 0;
    double bytesEach = 0;     // that must cross the memory for one: what the bound is made of
    double bandwidthGBs = 0;  // measured in the same rounds, on arrays of the same size
    std::string
        ceiling;  // the partial way that a way on the device is held against: loads and stores what the work needs, and nothing else
    std::vector<MatrixWay> ways;
    std::vector<std::string> absent;  // what was not measured, and why
    std::string failure;              // device and twin differ
};

struct MatrixOptions {
    uint32_t rounds = 50;
    uint32_t threads = 0;  // of what runs on the processor; 0: all
    double watchdogMs = 60000;
    std::function<void(double)> onProgress;
};

// count >= 1. Nothing is uploaded within a time. Vertices: all ways read and write the same two arrays, so that each finds of them in the caches what the
// one before left. Chains: two arrays of equal size, larger than the caches where that matters, since libraries keep columns where the device reads rows.
MatrixTable benchVertices(Device& device, uint64_t count, const MatrixOptions& options);
MatrixTable benchChain(Device& device, uint64_t count, const MatrixOptions& options);

}  // namespace plumb
