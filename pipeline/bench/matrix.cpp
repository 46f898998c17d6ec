// SPDX-License-Identifier: MIT
#include "pipeline/bench/matrix.h"

#include "pipeline/bench/peers.h"
#include "pipeline/bench/products.h"
#include "pipeline/passes/long_rows.h"
#include "pipeline/passes/parallel.h"

#include "host/binary64.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <random>
#include <span>
#include <thread>
#include <utility>

namespace plumb {
namespace {

constexpr uint32_t kMatrices = gpu::kMostMatrices;
constexpr uint32_t kPerLane = 1024;  // matrices an invocation of the tree; a shallow tree, since each level is a dispatch
constexpr double kU = 0x1p-24;

uint32_t threadsOf(const MatrixOptions& options) {
    return options.threads != 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
}

// Random rotation, so that no chain grows or fades, with a small shift.
glm::dmat4 randomMotion(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    glm::dvec4 q(normal(random), normal(random), normal(random), normal(random));
    q /= glm::length(q);
    const double x = q.x, y = q.y, z = q.z, w = q.w;
    glm::dmat4 m(1);
    m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0};
    m[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0};
    m[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0};
    m[3] = {normal(random) * 1e-3, normal(random) * 1e-3, normal(random) * 1e-3, 1};
    return m;
}

glm::mat4 rounded(const glm::dmat4& m) { return glm::mat4(m); }
gpu::Rows rowsOf(const glm::mat4& m) {
    const glm::mat4 t = glm::transpose(m);
    return {t[0], t[1], t[2], t[3]};
}
glm::mat4 matrixOf(const gpu::Rows& r) { return glm::transpose(glm::mat4(r.r0, r.r1, r.r2, r.r3)); }

// Rows x, y and w for the more accurate transforms, for vertices within [-1, 1]; the third coordinate of a motion stands for w.
gpu::LongRecord longRecordOf(const glm::dmat4& m) {
    const int exponent = blockExponent(1);
    const glm::dmat4 rows = glm::transpose(m);
    return {longRow(rows[0], exponent), longRow(rows[1], exponent), longRow(rows[2], exponent), float(std::ldexp(1.0, -exponent))};
}

// Way to the result: `run` is timed, `error` is called once after the last round.
struct Way {
    std::string name;
    std::function<void()> run;
    std::function<double()> error;
    enum class Kind { host, glm, device, partial } kind = Kind::host;
    std::vector<double> ms = {};
    uint64_t products = 0, steps = 0;
};
using Kind = Way::Kind;

// Measures: every round runs every way and the bandwidth once.
void measure(MatrixTable& table, std::vector<Way>& ways, const std::function<void()>& memory, double memoryBytes,
             const MatrixOptions& options) {
    std::vector<double> memoryMs, glmMs;
    memory();
    for (Way& way : ways) way.run(), way.run();
    for (uint32_t round = 0; round < options.rounds; ++round) {
        if (options.onProgress) options.onProgress(double(round) / options.rounds);
        memoryMs.push_back(msOf(memory));
        double glm = 0;
        for (Way& way : ways) {
            way.ms.push_back(msOf(way.run));
            if (way.kind == Kind::glm && (glm == 0 || way.ms.back() < glm)) glm = way.ms.back();
        }
        glmMs.push_back(glm);
    }
    const auto ceiling = std::find_if(ways.begin(), ways.end(), [&](const Way& way) { return way.name == table.ceiling; });
    PLUMB_ASSERT(ceiling != ways.end());
    const double bytesPerMs = memoryBytes / spreadOf(memoryMs).median;
    table.bandwidthGBs = bytesPerMs * 1e-6;
    for (Way& way : ways) {
        MatrixWay row;
        row.name = way.name;
        row.ms = spreadOf(way.ms);
        row.perSecond = double(table.count) / row.ms.median * 1e3;
        row.shareOfBound = row.perSecond * table.bytesEach / (bytesPerMs * 1e3);
        row.partial = way.kind == Kind::partial;
        if (way.kind == Kind::device || row.partial) row.ofDevice = ratioOf(ceiling->ms, way.ms);
        row.againstGlm = ratioOf(glmMs, way.ms);
        row.products = way.products;
        row.steps = way.steps;
        row.errorU = way.error();
        if (!std::isfinite(row.errorU)) table.failure = fmt::format("{}: a result is not finite", row.name);
        table.ways.push_back(std::move(row));
    }
}

// Largest entry of the difference over the largest entry of the exact result, in u. NaN stays NaN.
template <class Got, class Exact>
double errorOf(const Got& got, const Exact& exact, int entries) {
    double most = 0, largest = 0;
    for (int i = 0; i < entries; ++i) {
        largest = std::max(largest, std::abs(double(exact[i])));
        const double error = std::abs(double(got[i]) - double(exact[i]));
        if (!(error <= most)) most = error;
    }
    return most / largest / kU;
}

// Reference of the results: 64 bits of significand, so that binary64 rounded once has an error of its own.
using LongMatrix = glm::mat<4, 4, long double>;

double errorOfMatrix(const glm::mat4& got, const glm::dmat4& exact) { return errorOf(&got[0].x, &exact[0].x, 16); }

double errorOfVertices(std::span<const glm::vec4> got, std::span<const glm::dvec4> exact) {
    double most = 0;
    for (size_t i = 0; i < got.size(); ++i) {
        const double error = errorOf(&got[i].x, &exact[i].x, 4);
        if (!(error <= most)) most = error;
    }
    return most;
}

// Copies `from` to `to`, as many bytes as the ways read and write.
void copyAll(std::span<const glm::vec4> from, std::span<glm::vec4> to, uint32_t threads) {
    parallelBands(from.size(), 65536, threads,
                  [&](uint64_t begin, uint64_t end) { std::memcpy(&to[begin], &from[begin], (end - begin) * 16); });
}

}  // namespace

MatrixTable benchVertices(Device& device, uint64_t count, const MatrixOptions& options) {
    const uint32_t threads = threadsOf(options);
    std::mt19937_64 random(1);
    glm::dmat4 exact[kMatrices];
    glm::mat4 single[kMatrices];
    glm::dmat4 all(1);
    LongMatrix longest(1);
    std::vector<gpu::Rows> seven;
    for (uint32_t i = 0; i < kMatrices; ++i) {
        single[i] = rounded(randomMotion(random));
        exact[i] = glm::dmat4(single[i]);
        seven.push_back(rowsOf(single[i]));
        all = exact[i] * all;
        longest = LongMatrix(exact[i]) * longest;
    }
    // Composite of an application: multiplied in binary64, rounded once.
    const glm::mat4 composite = rounded(all);
    const std::vector<gpu::Rows> one = {rowsOf(composite)};

    const gpu::LongRecord longRecord = longRecordOf(all);
    Buffer<glm::vec4> in(device, count, "vertices");
    Buffer<gpu::VertexPair> out(device, pairsOf(count), "results");
    Buffer<gpu::Rows> oneOnDevice(device, 1, "matrix"), sevenOnDevice(device, kMatrices, "matrices");
    Buffer<gpu::LongRecord> longOnDevice(device, 1, "long rows");
    oneOnDevice.upload(one);
    sevenOnDevice.upload(seven);
    longOnDevice.upload(std::span(&longRecord, 1));
    const std::span<glm::vec4> results = verticesOf(out, count);
    std::vector<glm::vec4> twin(count);
    std::vector<glm::dvec4> wanted(count);
    std::uniform_real_distribution<float> within(-1, 1);
    for (uint64_t i = 0; i < count; ++i) {
        in.span()[i] = {within(random), within(random), within(random), 1.0f};
        wanted[i] = glm::dvec4(longest * glm::vec<4, long double>(in.span()[i]));
    }
    const std::span<const glm::vec4> vertices = std::as_const(in).span();

    MatrixTable table;
    table.work = "vertices";
    table.count = count;
    table.bytesEach = 2 * sizeof(glm::vec4);
    table.ceiling = "device, load and store alone";
    Recorder recorder(device);
    const DeviceLimits& limits = device.limits();
    std::vector<Way> ways;
    const auto onHost = [&](const std::string& name, Kind kind, const std::function<void()>& run, uint64_t matrices = 1) {
        ways.push_back({name, run, [&, run] { return run(), errorOfVertices(results, wanted); }, kind});
        ways.back().products = matrices * count, ways.back().steps = matrices;
    };
    // Adds a way on the device. It runs once more before its error is taken, so that its results stand in the array, and `twinRuns` leaves
    // the same bytes in `twin`.
    const auto onDevice = [&](const std::string& name, Kind kind, const std::function<void()>& record, uint64_t matrices,
                              const std::function<void()>& twinRuns) {
        const auto run = [&, record] {
            record();
            recorder.run(options.watchdogMs);
            recorder.takeTimes();
        };
        const auto error = [&, run, twinRuns, name, kind] {
            run();
            twinRuns();
            if (std::memcmp(results.data(), twin.data(), count * sizeof(glm::vec4)) != 0)
                table.failure = fmt::format("{} vertices, {}: device and twin differ", count, name);
            return kind == Kind::partial ? 0 : errorOfVertices(results, wanted);
        };
        ways.push_back({name, run, error, kind});
        ways.back().products = matrices * count, ways.back().steps = matrices;
    };
    const auto parallel = [&](uint32_t with, const std::function<void(std::span<const glm::vec4>, std::span<glm::vec4>)>& work) {
        parallelBands(count, 65536, with, [&](uint64_t begin, uint64_t end) {
            work(vertices.subspan(begin, end - begin), results.subspan(begin, end - begin));
        });
    };
    onDevice(
        "device, store alone", Kind::partial, [&] { recordMarks(recorder, limits, count, in, oneOnDevice, out); }, 0,
        [&] {
            for (uint64_t i = 0; i < count; ++i) twin[i] = gpu::markOf(one[0], uint32_t(i % verticesPerDispatch(limits)));
        });
    onDevice(
        table.ceiling, Kind::partial, [&] { recordVertices(recorder, limits, 0, count, in, oneOnDevice, out); }, 0,
        [&] { verticesCpu({}, vertices, twin, threads); });
    onDevice(
        "device, one composite", Kind::device, [&] { recordVertices(recorder, limits, 1, count, in, oneOnDevice, out); }, 1,
        [&] { verticesCpu(one, vertices, twin, threads); });
    const auto onDeviceLong = [&](const std::string& name, Numbers numbers) {
        onDevice(
            name, Kind::device, [&, numbers] { recordLongVertices(recorder, limits, numbers, count, in, longOnDevice, out); }, 1,
            [&, numbers] { longVerticesCpu(numbers, longRecord, vertices, twin, threads); });
    };
    onDeviceLong("device, one composite, block-scaled integers", Numbers::blockInteger);
    if (const std::string lacks = lacksBinary64(device); lacks.empty())
        onDeviceLong("device, one composite, binary64", Numbers::fp64);
    else
        table.absent.push_back("device, one composite, binary64: " + lacks);
    onDevice(
        "device, 7 one after another", Kind::device, [&] { recordVertices(recorder, limits, kMatrices, count, in, sevenOnDevice, out); },
        kMatrices, [&] { verticesCpu(seven, vertices, twin, threads); });
    onHost("twin, one composite", Kind::host, [&] { verticesCpu(one, vertices, results, threads); });
    onHost(
        "twin, 7 one after another", Kind::host, [&] { verticesCpu(seven, vertices, results, threads); }, kMatrices);
    onHost("GLM, one composite, 1 thread", Kind::glm, [&] { peers::glmVertices(composite, vertices, results); });
    onHost(fmt::format("GLM, one composite, {} threads", threads), Kind::glm,
           [&] { parallel(threads, [&](auto a, auto b) { peers::glmVertices(composite, a, b); }); });
    onHost(
        fmt::format("GLM, 7 one after another, {} threads", threads), Kind::host,
        [&] { parallel(threads, [&](auto a, auto b) { peers::glmVertices7(single, a, b); }); }, kMatrices);
    onHost(
        fmt::format("binary64, 7 one after another, rounded once, {} threads", threads), Kind::host,
        [&] {
            parallel(threads, [&](std::span<const glm::vec4> from, std::span<glm::vec4> to) {
                for (size_t i = 0; i < from.size(); ++i) {
                    glm::dvec4 v(from[i]);
                    for (const glm::dmat4& m : exact) v = m * v;
                    to[i] = glm::vec4(v);
                }
            });
        },
        kMatrices);
    std::string why;
    if (peers::hasEigen(why))
        onHost(fmt::format("Eigen, one composite, {} threads", threads), Kind::host,
               [&] { parallel(threads, [&](auto a, auto b) { peers::eigenVertices(composite, a, b); }); });
    else
        table.absent.push_back("Eigen: " + why);
    if (peers::hasOpenBlas(why))
        onHost("OpenBLAS sgemm, one composite", Kind::host, [&] { peers::openBlasVertices(composite, vertices, results); });
    else
        table.absent.push_back("OpenBLAS: " + why);
    measure(
        table, ways, [&] { copyAll(vertices, results, threads); }, double(count) * table.bytesEach, options);
    return table;
}

MatrixTable benchChain(Device& device, uint64_t count, const MatrixOptions& options) {
    const uint32_t threads = threadsOf(options);
    MatrixTable table;
    table.work = "chain";
    table.count = count;
    table.bytesEach = sizeof(gpu::Rows);
    table.ceiling = "device, load alone";
    std::mt19937_64 random(2);
    std::vector<glm::mat4> chain(count);
    LongMatrix all(1);
    for (glm::mat4& m : chain) {
        m = rounded(randomMotion(random));
        all = all * LongMatrix(m);
    }
    const glm::dmat4 wanted(all);
    Buffer<gpu::Rows> in(device, count, "chain"), left(device, count / 2 + 1, "products"),
        right(device, count / 4 + 1, "products of products");
    std::transform(chain.begin(), chain.end(), in.span().begin(), rowsOf);
    const std::span<const gpu::Rows> rows = std::as_const(in).span();
    Recorder recorder(device);
    const Buffer<gpu::Rows>* last = nullptr;
    const auto treeOnDevice = [&](Level level, uint32_t perLane) {
        const Buffer<gpu::Rows>* from = &in;
        for (uint64_t n = count; n > 1 || from == &in; n = (n + perLane - 1) / perLane) {
            const Buffer<gpu::Rows>* to = from == &left ? &right : &left;
            recordChainLevel(recorder, device.limits(), level, perLane, n, *from, *to);
            from = to;
        }
        recorder.run(options.watchdogMs);
        recorder.takeTimes();
        last = from;
    };
    std::vector<gpu::Rows> a, b;
    const auto treeOnTwin = [&](Level level, uint32_t perLane) {
        std::span<const gpu::Rows> from = rows;
        for (uint64_t n = count; n > 1 || from.data() == rows.data();) {
            n = (n + perLane - 1) / perLane;
            std::vector<gpu::Rows>& to = from.data() == a.data() ? b : a;
            if (to.size() < n) to.resize(n);
            chainLevelCpu(level, perLane, from, std::span(to).first(n), threads);
            from = std::span<const gpu::Rows>(to).first(n);
        }
        return from[0];
    };
    std::vector<Way> ways;
    // Counts of a tree. A level multiplies runs of perLane matrices, all at once, each from left to right.
    const auto counted = [&](uint64_t perLane) {
        ways.back().products = count - 1;
        for (uint64_t n = count; n > 1; n = (n + perLane - 1) / perLane) ways.back().steps += std::min(perLane, n) - 1;
    };
    const auto tree = [&](const std::string& name, Kind kind, Level level, uint32_t perLane) {
        const auto error = [&, kind, level, perLane, name] {
            treeOnDevice(level, perLane);
            const gpu::Rows got = last->span()[0], want = treeOnTwin(level, perLane);
            const auto bytesOf = [](const gpu::Rows& of) { return std::as_bytes(std::span(&of, 1)); };
            if (!std::ranges::equal(bytesOf(got), bytesOf(want)))
                table.failure = fmt::format("a chain of {}, {}: device and twin differ", count, name);
            return kind == Kind::partial ? 0 : errorOfMatrix(matrixOf(got), wanted);
        };
        ways.push_back({name, [&, level, perLane] { treeOnDevice(level, perLane); }, error, kind});
        if (kind != Kind::partial) counted(perLane);
    };
    tree(table.ceiling, Kind::partial, Level::sums, kPerLane);
    tree("device, pairwise tree", Kind::device, Level::products, 2);
    tree(fmt::format("device, tree of {}", kPerLane), Kind::device, Level::products, kPerLane);
    if (count <= gpu::kMostPerLane)
        tree("device, sequential", Kind::device, Level::products, uint32_t(std::max<uint64_t>(2, count)));
    else
        table.absent.push_back(fmt::format(
            "device, sequential: an invocation multiplies at most {} (a loop of lavapipe ends after 65,535 steps), the chain has {}",
            gpu::kMostPerLane, count));
    glm::mat4 product(1);
    ways.push_back({fmt::format("twin, tree of {}", kPerLane), [&] { product = matrixOf(treeOnTwin(Level::products, kPerLane)); },
                    [&] { return errorOfMatrix(matrixOf(treeOnTwin(Level::products, kPerLane)), wanted); }});
    counted(kPerLane);
    const auto glmSequential = [&] { product = peers::glmChain(chain); };
    ways.push_back(
        {"GLM, sequential", glmSequential, [&, glmSequential] { return glmSequential(), errorOfMatrix(product, wanted); }, Kind::glm});
    counted(std::max<uint64_t>(2, count));
    const auto glmTree = [&] {
        const uint64_t part = (count + threads - 1) / threads;
        std::vector<glm::mat4> parts((count + part - 1) / part);
        parallelBands(parts.size(), 1, threads, [&](uint64_t begin, uint64_t end) {
            for (uint64_t i = begin; i < end; ++i)
                parts[i] = peers::glmChain(std::span<const glm::mat4>(chain).subspan(i * part, std::min(part, count - i * part)));
        });
        product = peers::glmChain(parts);
    };
    ways.push_back({fmt::format("GLM, {} parts, {} threads", threads, threads), glmTree,
                    [&, glmTree] { return glmTree(), errorOfMatrix(product, wanted); }});
    ways.back().products = count - 1;
    ways.back().steps = (count + threads - 1) / threads - 1 + std::min<uint64_t>(threads, count) - 1;
    const auto binary64 = [&] {
        glm::dmat4 sum(1);
        for (const glm::mat4& m : chain) sum = sum * glm::dmat4(m);
        product = rounded(sum);
    };
    ways.push_back({"binary64, sequential, rounded once", binary64, [&, binary64] { return binary64(), errorOfMatrix(product, wanted); }});
    counted(std::max<uint64_t>(2, count));
    std::vector<uint64_t> sums(threads);
    const auto readAll = [&] {
        const std::span<const uint64_t> words(reinterpret_cast<const uint64_t*>(rows.data()), count * sizeof(gpu::Rows) / 8);
        const uint64_t part = (words.size() + threads - 1) / threads;
        parallelBands(threads, 1, threads, [&](uint64_t begin, uint64_t end) {
            for (uint64_t i = begin; i < end; ++i)
                if (i * part < words.size()) sums[i] += peers::sumWords(words.subspan(i * part, std::min(part, words.size() - i * part)));
        });
    };
    measure(table, ways, readAll, double(count) * table.bytesEach, options);
    return table;
}

}  // namespace plumb
