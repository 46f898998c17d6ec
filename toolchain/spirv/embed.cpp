// SPDX-License-Identifier: MIT
// plumb_spirv_embed NAME IN.spv OUT.spv OUT.h OUT.cpp
// Decorates the result of every floating-point arithmetic instruction of a module with NoContraction, so that no
// driver may fuse or reassociate it (GLSL's `precise`, without writing it), and embeds the words as
// `plumb::spirv::NAME`. RelaxedPrecision is taken away; all else stays as it is.
// SPIR-V 1.5 specification: section 2.3 (physical layout), 2.4 (logical layout), 3.20 (decorations).
#include <array>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr uint32_t kMagic = 0x07230203u;
constexpr size_t kHeaderWords = 5;
constexpr uint32_t kOpDecorate = 71, kOpTypeVoid = 19, kOpTypeForwardPointer = 39;
constexpr uint32_t kNoContraction = 42, kRelaxedPrecision = 0;

bool isFloatArithmetic(uint32_t opcode) {
    switch (opcode) {
        case 127:  // FNegate
        case 129:  // FAdd
        case 131:  // FSub
        case 133:  // FMul
        case 136:  // FDiv
        case 140:  // FRem
        case 141:  // FMod
        case 142:  // VectorTimesScalar
        case 143:  // MatrixTimesScalar
        case 144:  // VectorTimesMatrix
        case 145:  // MatrixTimesVector
        case 146:  // MatrixTimesMatrix
        case 147:  // OuterProduct
        case 148:  // Dot
            return true;
        default:
            return false;
    }
}

// loose: nothing is decorated.
std::vector<uint32_t> decorated(const std::vector<uint32_t>& words, bool loose) {
    if (words.size() < kHeaderWords || words[0] != kMagic) throw std::runtime_error("not a SPIR-V module");
    std::set<uint32_t> alreadyDecorated;
    std::vector<uint32_t> results;
    size_t firstType = 0;  // annotations stand directly before the types
    for (size_t at = kHeaderWords; at < words.size();) {
        const uint32_t opcode = words[at] & 0xffffu, count = words[at] >> 16;
        if (count == 0 || at + count > words.size()) throw std::runtime_error("truncated instruction");
        if (opcode == kOpDecorate && count >= 3 && words[at + 2] == kNoContraction) alreadyDecorated.insert(words[at + 1]);
        if (firstType == 0 && opcode >= kOpTypeVoid && opcode <= kOpTypeForwardPointer) firstType = at;
        if (isFloatArithmetic(opcode)) results.push_back(words[at + 2]);
        at += count;
    }
    if (firstType == 0) throw std::runtime_error("module without types");
    // glslang marks subgroup built-ins RelaxedPrecision; a permission to be less exact is never wanted here.
    std::vector<uint32_t> out(words.begin(), words.begin() + long(kHeaderWords));
    for (size_t at = kHeaderWords; at < firstType; at += words[at] >> 16) {
        const bool relaxed = (words[at] & 0xffffu) == kOpDecorate && words[at] >> 16 == 3 && words[at + 2] == kRelaxedPrecision;
        if (!relaxed) out.insert(out.end(), words.begin() + long(at), words.begin() + long(at + (words[at] >> 16)));
    }
    for (const uint32_t result : results)
        if (!loose && !alreadyDecorated.contains(result)) out.insert(out.end(), {3u << 16 | kOpDecorate, result, kNoContraction});
    out.insert(out.end(), words.begin() + long(firstType), words.end());
    return out;
}

// FIPS 180-4.
std::string sha256Hex(const std::vector<uint8_t>& message) {
    static constexpr std::array<uint32_t, 64> kRoundConstants = {
        0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01, 0x243185be,
        0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa,
        0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967, 0x27b70a85,
        0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3,
        0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f,
        0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};
    std::array<uint32_t, 8> state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::vector<uint8_t> padded = message;
    padded.push_back(0x80);
    while (padded.size() % 64 != 56) padded.push_back(0);
    for (int shift = 56; shift >= 0; shift -= 8) padded.push_back(uint8_t(uint64_t(message.size()) * 8 >> shift));
    for (size_t block = 0; block < padded.size(); block += 64) {
        std::array<uint32_t, 64> w;
        for (size_t i = 0; i < 16; ++i)
            w[i] = uint32_t(padded[block + 4 * i]) << 24 | uint32_t(padded[block + 4 * i + 1]) << 16 |
                   uint32_t(padded[block + 4 * i + 2]) << 8 | uint32_t(padded[block + 4 * i + 3]);
        for (size_t i = 16; i < 64; ++i) {
            const uint32_t s0 = std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ w[i - 15] >> 3;
            const uint32_t s1 = std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ w[i - 2] >> 10;
            w[i] = w[i - 16] + s0 + w[i - 7] + s1;
        }
        auto [a, b, c, d, e, f, g, h] = state;
        for (size_t i = 0; i < 64; ++i) {
            const uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
            const uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + kRoundConstants[i] + w[i];
            const uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
            const uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
            h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
        }
        const std::array<uint32_t, 8> add = {a, b, c, d, e, f, g, h};
        for (size_t i = 0; i < 8; ++i) state[i] += add[i];
    }
    std::string hex;
    for (const uint32_t word : state) {
        char text[9];
        std::snprintf(text, sizeof text, "%08x", word);
        hex += text;
    }
    return hex;
}

std::vector<uint8_t> bytesOf(const std::vector<uint32_t>& words) {
    std::vector<uint8_t> bytes(words.size() * 4);
    std::memcpy(bytes.data(), words.data(), bytes.size());
    return bytes;
}

std::string header(const std::string& name) {
    return "// Generated by plumb_spirv_embed from " + name + ".\n#pragma once\n#include \"host/module.h\"\n" +
           "namespace plumb::spirv {\nextern const Module " + name + ";\n}  // namespace plumb::spirv\n";
}

// The words stand in a source of their own, so that a changed shader does not compile its recorder again.
std::string source(const std::string& name, const std::vector<uint32_t>& words) {
    std::string text = "// Generated by plumb_spirv_embed from " + name + ".\n#include <spirv/" + name + ".h>\n" +
                       "namespace plumb::spirv {\nnamespace {\nconstexpr uint32_t kWords[] = {";
    for (size_t i = 0; i < words.size(); ++i) {
        char word[16];
        std::snprintf(word, sizeof word, "%s0x%08x,", i % 10 == 0 ? "\n" : "", words[i]);
        text += word;
    }
    return text + "};\n}  // namespace\nconstinit const Module " + name + "{\"" + name + "\", kWords,\n    \"" + sha256Hex(bytesOf(words)) +
           "\"};\n}  // namespace plumb::spirv\n";
}

std::vector<uint32_t> read(const char* path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    if (!file || bytes.size() % 4 != 0) throw std::runtime_error(std::string("cannot read whole words from ") + path);
    std::vector<uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), bytes.size());
    return words;
}

void write(const char* path, const void* data, size_t bytes) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(static_cast<const char*>(data), std::streamsize(bytes));
    file.close();
    if (!file) throw std::runtime_error(std::string("cannot write ") + path);
}

}  // namespace

int main(int argc, char** argv) {
    const bool loose = argc == 9 && std::strcmp(argv[8], "--loose") == 0;
    if (argc != 8 && !loose) {
        std::fputs(
            "usage: plumb_spirv_embed NAME IN.spv OUT.spv OUT.h OUT.cpp FUNCTIONS_IN.spv FUNCTIONS_OUT.spv [--loose]\n"
            "FUNCTIONS: the module before its functions were inlined, with the same decorations, for the lint\n"
            "--loose: without NoContraction, for a module that asks what the device does then\n",
            stderr);
        return 2;
    }
    try {
        const std::string name = argv[1];
        for (const char c : name)
            if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') throw std::runtime_error("the name is not a C++ identifier");
        const std::vector<uint32_t> words = decorated(read(argv[2]), loose), functions = decorated(read(argv[6]), loose);
        const std::string declares = header(name), defines = source(name, words);
        write(argv[3], words.data(), words.size() * 4);
        write(argv[7], functions.data(), functions.size() * 4);
        write(argv[4], declares.data(), declares.size());
        write(argv[5], defines.data(), defines.size());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "plumb_spirv_embed: %s: %s\n", argv[2], error.what());
        return 1;
    }
}
