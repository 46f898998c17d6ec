// SPDX-License-Identifier: MIT
#include "pipeline/bench/peers.h"

#include <dlfcn.h>
#include <cstdlib>

#ifdef PLUMB_EIGEN
#include <Eigen/Core>
#endif

// Function clones are not used under a sanitizer, because their resolvers run before it is ready.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
#define PLUMB_CLONES __attribute__((target_clones("avx512f", "arch=haswell", "default")))
#else
#define PLUMB_CLONES
#endif

namespace plumb::peers {
namespace {

using Sgemm = void (*)(int order, int transA, int transB, int m, int n, int k, float alpha, const float* a, int lda, const float* b,
                       int ldb, float beta, float* c, int ldc);

Sgemm openBlas() {
    static const Sgemm kFound = [] {
        // OpenBLAS's threads would spin for some 30 ms after each call, on the processors of the next measurement. 2^4 cycles is the least
        // it accepts.
        ::setenv("OPENBLAS_THREAD_TIMEOUT", "4", 0);
        void* library = ::dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL);
        return library ? reinterpret_cast<Sgemm>(::dlsym(library, "cblas_sgemm")) : nullptr;
    }();
    return kFound;
}

}  // namespace

PLUMB_CLONES void glmVertices(const glm::mat4& m, std::span<const glm::vec4> in, std::span<glm::vec4> out) {
    const glm::mat4 own = m;
    for (size_t i = 0; i < in.size(); ++i) out[i] = own * in[i];
}

PLUMB_CLONES void glmVertices7(const glm::mat4 (&m)[7], std::span<const glm::vec4> in, std::span<glm::vec4> out) {
    for (size_t i = 0; i < in.size(); ++i) out[i] = m[6] * (m[5] * (m[4] * (m[3] * (m[2] * (m[1] * (m[0] * in[i]))))));
}

PLUMB_CLONES glm::mat4 glmChain(std::span<const glm::mat4> chain) {
    glm::mat4 product = chain[0];
    for (size_t i = 1; i < chain.size(); ++i) product = product * chain[i];
    return product;
}

PLUMB_CLONES uint64_t sumWords(std::span<const uint64_t> words) {
    uint64_t sum = 0;
    for (const uint64_t word : words) sum += word;
    return sum;
}

#ifdef PLUMB_EIGEN
bool hasEigen(std::string&) { return true; }
void eigenVertices(const glm::mat4& m, std::span<const glm::vec4> in, std::span<glm::vec4> out) {
    using Points = Eigen::Matrix<float, 4, Eigen::Dynamic>;
    const Eigen::Map<const Eigen::Matrix4f> matrix(&m[0].x);
    const Eigen::Map<const Points> from(&in[0].x, 4, Eigen::Index(in.size()));
    Eigen::Map<Points> to(&out[0].x, 4, Eigen::Index(out.size()));
    to.noalias() = matrix.lazyProduct(from);
}
#else
bool hasEigen(std::string& why) {
    why = "the build found no headers of Eigen 3";
    return false;
}
void eigenVertices(const glm::mat4&, std::span<const glm::vec4>, std::span<glm::vec4>) { std::abort(); }
#endif

bool hasOpenBlas(std::string& why) {
    if (openBlas()) return true;
    why = "there is no libopenblas.so.0";
    return false;
}
void openBlasVertices(const glm::mat4& m, std::span<const glm::vec4> in, std::span<glm::vec4> out) {
    constexpr int kColumnMajor = 102, kNoTranspose = 111;
    openBlas()(kColumnMajor, kNoTranspose, kNoTranspose, 4, int(in.size()), 4, 1.0f, &m[0].x, 4, &in[0].x, 4, 0.0f, &out[0].x, 4);
}

}  // namespace plumb::peers
