// SPDX-License-Identifier: MIT
// Runs a fuzz target without libFuzzer: every seed of a folder whole, cut at every byte (long ones: at 400 places), and MUTATIONS times
// changed by a fixed sequence of numbers, so that a plain run repeats itself. usage: PROGRAM FOLDER MUTATIONS; the folder's name says which reader.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
extern std::string_view fuzzedExtension;

namespace {

constexpr size_t kCuts = 400;

void runOne(const std::string& bytes) { LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()); }

std::string mutated(std::string bytes, std::mt19937& random) {
    const auto below = [&](size_t n) { return size_t(random()) % std::max<size_t>(n, 1); };
    for (size_t change = 1 + below(4); change > 0 && !bytes.empty(); --change) {
        const size_t at = below(bytes.size());
        switch (below(5)) {
            case 0:
                bytes[at] = char(random());
                break;  // another byte
            case 1:
                bytes[at] = char(uint8_t(bytes[at]) ^ 1u << below(8));
                break;  // one bit
            case 2:
                bytes.erase(at, 1 + below(8));
                break;  // a piece lost
            case 3:
                bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(16)));
                break;  // a piece repeated
            default: {  // a word that readers stumble over
                static constexpr const char* kWords[] = {
                    "-1", "0", "nan", "inf", "1e39", "4294967295", "999999999999", "-", "/", "\n", "\xff\xff\xff\xff", "\""};
                bytes.insert(at, kWords[below(std::size(kWords))]);
            }
        }
    }
    return bytes;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return std::fputs("usage: PROGRAM FOLDER MUTATIONS\n", stderr), 2;
    const std::string extension = std::filesystem::path(argv[1]).filename().string();
    fuzzedExtension = extension;
    std::vector<std::filesystem::path> seeds;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) seeds.push_back(entry.path());
    std::sort(seeds.begin(), seeds.end());
    std::mt19937 random(1);
    size_t runs = 0;
    for (const auto& seed : seeds) {
        std::ifstream file(seed, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(file), {}};
        runOne(bytes), ++runs;
        const size_t step = std::max<size_t>(1, bytes.size() / kCuts);
        for (size_t cut = 0; cut < bytes.size(); cut += step, ++runs) runOne(bytes.substr(0, cut));
        for (int n = std::atoi(argv[2]); n > 0; --n, ++runs) runOne(mutated(bytes, random));
    }
    std::printf("%zu seeds, %zu runs, 0 findings\n", seeds.size(), runs);
    return seeds.empty() ? 1 : 0;
}
