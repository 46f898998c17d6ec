// SPDX-License-Identifier: MIT
#include "pipeline/fingerprint/file.h"

#include "host/error.h"

#include <fmt/core.h>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

// Seven bits a byte, the lowest first; a set top bit says that more follow.
void putNumber(std::string& bytes, uint64_t number) {
    for (; number >= 128; number >>= 7) bytes += char((number & 127u) | 128u);
    bytes += char(number);
}
bool takeNumber(std::span<const uint8_t> bytes, size_t& at, uint64_t& number) {
    number = 0;
    for (int shift = 0; shift < 63; shift += 7) {
        if (at == bytes.size()) return false;
        number |= uint64_t(bytes[at] & 127u) << shift;
        if (bytes[at++] < 128) return true;
    }
    return false;
}

std::string base64(const std::string& bytes) {
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k) text += k <= bytes.size() - i ? kDigits[group >> (18 - 6 * k) & 63u] : '=';
    }
    return text;
}

bool bytesOf(const std::string& text, std::vector<uint8_t>& bytes) {
    if (text.size() % 4 != 0) return false;
    for (size_t i = 0; i < text.size(); i += 4) {
        uint32_t group = 0;
        size_t digits = 0;
        for (size_t k = 0; k < 4; ++k) {
            const size_t digit = std::string_view(kDigits, 64).find(text[i + k]);
            if (digit == std::string_view::npos && (text[i + k] != '=' || i + 4 != text.size() || k < 2)) return false;
            if (digit != std::string_view::npos && digits++ != k) return false;
            group = group << 6 | (digit == std::string_view::npos ? 0u : uint32_t(digit));
        }
        for (size_t k = 0; k + 1 < digits; ++k) bytes.push_back(uint8_t(group >> (16 - 8 * k)));
    }
    return true;
}

const char* wordOf(Verdict verdict) {
    switch (verdict) {
        case Verdict::within:
            return "within";
        case Verdict::beyond:
            return "beyond";
        case Verdict::open:
            return "open";
        case Verdict::failed:
            break;
    }
    return "failed";
}

Json ulps(uint64_t error) { return error == kNoPromise ? Json() : Json(double(error) / double(kUlp)); }
std::string hex(uint32_t bits) { return fmt::format("{:08x}", bits); }

Json traitJson(const Trait& trait, const Questions& asked, const Answers& answers, const Finding& finding) {
    Json json;
    json["name"] = trait.name;
    json["group"] = trait.group;
    json["what"] = trait.what;
    json["allowance"] = trait.allowance;
    json["planes"] = trait.planes;
    json["verdict"] = wordOf(finding.verdict);
    json["finding"] = finding.text;
    json["questions"] = asked.questions.size();
    json["differing"] = finding.differing;
    json["beyond"] = finding.beyond;
    if (finding.verdict == Verdict::failed) return json;
    if (trait.inUlp()) {
        json["ulp"] = ulps(finding.error);
        json["ulpAllowed"] = ulps(finding.allowed);
    }
    if (finding.differing != 0 || finding.error != 0) {
        const Question& q = asked.questions[finding.worst];
        json["at"] = {{"question", finding.worst},
                      {"words", {hex(q[0]), hex(q[1]), hex(q[2]), hex(q[3])}},
                      {"text", questionText(trait, q)},
                      {"expected", hex(asked.expected[finding.worst])},
                      {"got", hex(answers.words[finding.worst])}};
    }
    if (!finding.decades.empty()) {
        json["decades"] = Json::array();
        for (const Decade& d : finding.decades)
            json["decades"].push_back({d.power, ulps(d.error), ulps(d.allowed), hex(asked.questions[d.item][0])});
    }
    json["sha256"] = hashOf(trait, answers);
    json["answers"] = packed(answers.words, asked.expected);
    return json;
}

Json sweepJson(const Sweep& sweep) {
    Json json{{"trait", sweep.trait}, {"failure", sweep.failure}, {"beyond", sweep.beyond}, {"firstBeyond", hex(sweep.firstBeyond)}};
    json["blocks"] = Json::array();
    for (const SweepBlock& b : sweep.blocks)
        json["blocks"].push_back({hex(b.first), ulps(b.error), hex(b.worst), hex(b.worstAnswer), b.hash});
    return json;
}

uint32_t wordOf(const Json& text) {
    const std::string digits = text.get<std::string>();
    if (digits.size() != 8 || digits.find_first_not_of("0123456789abcdef") != digits.npos)
        throw std::invalid_argument("not eight hexadecimal digits");
    return uint32_t(std::stoul(digits, nullptr, 16));
}

Sweep sweepOf(const Json& json) {
    Sweep sweep;
    sweep.trait = json.at("trait").get<std::string>();
    sweep.failure = json.at("failure").get<std::string>();
    sweep.beyond = json.at("beyond").get<uint64_t>();
    sweep.firstBeyond = wordOf(json.at("firstBeyond"));
    for (const Json& b : json.at("blocks"))
        sweep.blocks.push_back({wordOf(b.at(0)), uint64_t(b.at(1).get<double>() * double(kUlp)), wordOf(b.at(2)), wordOf(b.at(3)),
                                b.at(4).get<std::string>()});
    return sweep;
}

}  // namespace

std::string packed(std::span<const uint32_t> words, std::span<const uint32_t> expected) {
    PLUMB_ASSERT(words.size() == expected.size());
    std::string bytes;
    for (size_t i = 0; i < words.size(); ++i) {
        const uint32_t apart = words[i] - expected[i];
        putNumber(bytes, apart << 1 ^ (apart >> 31 != 0 ? ~0u : 0u));
        if (apart != 0) continue;
        size_t run = 0;  // further zeros
        while (i + 1 < words.size() && words[i + 1] == expected[i + 1]) ++run, ++i;
        putNumber(bytes, run);
    }
    return base64(bytes);
}

bool unpack(const std::string& text, std::span<const uint32_t> expected, std::vector<uint32_t>& words) {
    std::vector<uint8_t> bytes;
    words.clear();
    if (!bytesOf(text, bytes)) return false;
    for (size_t at = 0; at < bytes.size();) {
        uint64_t number = 0, run = 0;
        if (!takeNumber(bytes, at, number) || number > 0xffffffffu || words.size() == expected.size()) return false;
        const uint32_t folded = uint32_t(number);
        words.push_back(expected[words.size()] + (folded >> 1 ^ (0u - (folded & 1u))));
        if (number != 0) continue;
        if (!takeNumber(bytes, at, run) || run > expected.size() - words.size()) return false;
        for (; run != 0; --run) words.push_back(expected[words.size()]);
    }
    return words.size() == expected.size();
}

Json jsonOf(const Fingerprint& fingerprint, std::span<const Finding> findings, const Json& tool) {
    Json json;
    json["schema"] = kSchema;
    json["version"] = kVersion;
    json["tool"] = tool;
    const DeviceInfo& d = fingerprint.device;
    json["device"] = {{"name", d.name},      {"type", d.type}, {"driver", d.driver}, {"driverInfo", d.driverInfo},
                      {"api", d.apiVersion}, {"uuid", d.uuid}};
    json["samples"] = fingerprint.samples;
    json["hash"] = hashOf(fingerprint);
    json["time_ms"] = fingerprint.timeMs;
    json["traits"] = Json::array();
    for (size_t i = 0; i < fingerprint.answers.size(); ++i)
        json["traits"].push_back(traitJson(traits()[i], allQuestions(fingerprint.samples)[i], fingerprint.answers[i], findings[i]));
    json["allFloats"] = Json::array();
    for (const Sweep& sweep : fingerprint.sweeps) json["allFloats"].push_back(sweepJson(sweep));
    return json;
}

Fingerprint fingerprintOf(const std::string& path, const std::string& text) {
    const auto refuse = [&](const std::string& what) { return inputError(path, what); };
    Fingerprint fingerprint;
    try {
        const Json json = Json::parse(text);
        if (!json.is_object() || json.value("schema", "") != kSchema)
            throw refuse(fmt::format("is no fingerprint of this program: its 'schema' is {}, and '{}' is wanted",
                                     json.is_object() && json.contains("schema") ? json["schema"].dump() : "missing", kSchema));
        if (json.at("version").get<uint32_t>() != kVersion)
            throw refuse(fmt::format(
                "has the questions of version {}, and this program those of version {}: make both fingerprints with one program",
                json.at("version").dump(), kVersion));
        fingerprint.samples = json.at("samples").get<uint32_t>();
        if (fingerprint.samples == 0 || fingerprint.samples > 1u << 20)
            throw refuse(fmt::format("'samples' is {}, accepted: 1 to 1048576", fingerprint.samples));
        const Json& device = json.at("device");
        fingerprint.device.name = device.at("name").get<std::string>();
        fingerprint.device.driver = device.at("driver").get<std::string>();
        fingerprint.device.driverInfo = device.at("driverInfo").get<std::string>();
        const Json& list = json.at("traits");
        if (list.size() != traits().size())
            throw refuse(fmt::format("has {} traits, and version {} has {}", list.size(), kVersion, traits().size()));
        for (size_t i = 0; i < traits().size(); ++i) {
            const Trait& trait = traits()[i];
            if (list[i].at("name").get<std::string>() != trait.name)
                throw refuse(fmt::format("trait {} is '{}', and version {} has '{}' there", i, list[i].at("name").get<std::string>(),
                                         kVersion, trait.name));
            Answers& answers = fingerprint.answers.emplace_back();
            if (list[i].at("verdict").get<std::string>() == "failed") {
                answers.failure = list[i].at("finding").get<std::string>();
                continue;
            }
            if (!unpack(list[i].at("answers").get<std::string>(), allQuestions(fingerprint.samples)[i].expected, answers.words))
                throw refuse(fmt::format("the answers of trait '{}' are torn", trait.name));
            if (hashOf(trait, answers) != list[i].at("sha256").get<std::string>())
                throw refuse(fmt::format("the answers of trait '{}' are not those of its 'sha256'", trait.name));
        }
        for (const Json& sweep : json.at("allFloats")) fingerprint.sweeps.push_back(sweepOf(sweep));
        if (hashOf(fingerprint) != json.at("hash").get<std::string>()) throw refuse("its traits are not those of its 'hash'");
    } catch (const Json::parse_error& e) {
        throw inputError(fmt::format("{}: byte {}", path, e.byte), "the JSON ends or breaks here: the file is truncated or no fingerprint");
    } catch (const Json::exception& e) {
        throw refuse(fmt::format("is no whole fingerprint: {}", e.what()));
    } catch (const std::invalid_argument& e) {
        throw refuse(fmt::format("is no whole fingerprint: {}", e.what()));
    }
    return fingerprint;
}

}  // namespace plumb::fingerprint
