// SPDX-License-Identifier: MIT
// A faulty driver for each trait: the comparison names this trait, with its first input and both answers, and no other. Two fingerprints of
// one device are the same.
#include "host/driver.h"
#include "pipeline/fingerprint/file.h"
#include "tests/fault/planted_driver.h"
#include "tests/support/device_fixture.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::test {
namespace {

namespace fp = fingerprint;

constexpr uint32_t kFew = 4096;  // questions of a trait with decades; the others have all of theirs

using Planted = DeviceTest;

// Through the file, as `plumb devices --compare` has them.
fp::Fingerprint throughFile(const fp::Fingerprint& f) {
    std::vector<fp::Finding> findings;
    for (size_t i = 0; i < f.answers.size(); ++i)
        findings.push_back(fp::findingOf(fp::traits()[i], fp::allQuestions(f.samples)[i], f.answers[i]));
    return fp::fingerprintOf("f.json", fp::jsonOf(f, findings, {}).dump());
}

const fp::Fingerprint& sound() {
    static const fp::Fingerprint one = throughFile(fp::ask(*DeviceEnvironment::device(), kFew));
    return one;
}

TEST_F(Planted, EveryTraitHasADriver) {
    std::map<std::string, int> drivers;
    for (const PlantedDriver& driver : plantedDrivers()) ++drivers[driver.trait];
    EXPECT_GE(fp::traits().size(), 30u);
    for (const fp::Trait& trait : fp::traits()) EXPECT_EQ(drivers[trait.name], 1) << trait.name;
    EXPECT_EQ(drivers.size(), fp::traits().size());
    for (size_t i = 0; i < fp::traits().size(); ++i) EXPECT_EQ(sound().answers[i].failure, "") << fp::traits()[i].name;
}

TEST_F(Planted, EachIsNamedAndNoOther) {
    DeviceRequest request = DeviceEnvironment::request();
    request.validation = false;  // what a driver does with its words is not the application's fault
    // One device for all: a pipeline whose words a driver leaves alone is that of the driver before.
    Device device = Device::open(Device::choose(request), request);
    for (const PlantedDriver& driver : plantedDrivers()) {
        if (const char* only = std::getenv("PLUMB_ONLY"); only && driver.trait != std::string(only)) continue;
        size_t changed = 0;
        plantDriver(device, [&](std::string_view module, std::vector<uint32_t>& words) {
            // Without NoContraction a driver may join operations; a fault of one of them would only keep it from that.
            if (module == "fingerprint_loose" && !driver.loose) return;
            Editor editor(words);
            driver.change(editor);
            const Words after = editor.words();
            changed += after != words ? 1 : 0;
            words = after;
        });
        const fp::Fingerprint faulty = throughFile(fp::ask(device, kFew));
        EXPECT_GT(changed, 0u) << driver.trait << ": " << driver.fault;
        const std::vector<fp::Difference> found = fp::differences(sound(), faulty);
        std::string named;
        for (const fp::Difference& d : found) named += d.trait + " at " + d.question + ": " + d.left + " / " + d.right + "; ";
        std::printf("%-22s %s: %s\n", driver.trait, driver.fault, named.c_str());
        EXPECT_EQ(found.size(), 1u) << driver.trait << " (" << driver.fault << "): " << named;
        if (found.size() != 1) continue;
        EXPECT_EQ(found[0].trait, driver.trait);
        EXPECT_GT(found[0].differing, 0u);
        EXPECT_NE(found[0].question, "");
        EXPECT_NE(found[0].left, found[0].right);
        EXPECT_NE(fp::hashOf(sound()), fp::hashOf(faulty));
    }
}

TEST_F(Planted, EqualRunsAreEqual) {
    const int pairs = std::getenv("PLUMB_LONG") ? 20 : 3;
    for (int pair = 0; pair < pairs; ++pair) {
        const fp::Fingerprint again = throughFile(fp::ask(device(), kFew));
        EXPECT_EQ(fp::hashOf(again), fp::hashOf(sound()));
        EXPECT_TRUE(fp::differences(sound(), again).empty());
    }
}

// The references that serve many exponents at once are those of the functions themselves.
TEST_F(Planted, EveryFloatIsJudgedAsEachIs) {
    const std::vector<uint32_t> fields = {0, 133, 255};
    const std::vector<fp::Sweep> sweeps = fp::sweep(device(), 2, {}, fields);
    ASSERT_EQ(sweeps.size(), 6u);
    for (const fp::Sweep& sweep : sweeps) {
        EXPECT_EQ(sweep.failure, "");
        EXPECT_EQ(sweep.beyond, 0u) << sweep.trait << " at " << fp::floatText(sweep.firstBeyond);
        ASSERT_EQ(sweep.blocks.size(), 2 * fields.size());
        const auto trait =
            std::find_if(fp::traits().begin(), fp::traits().end(), [&](const fp::Trait& t) { return t.name == sweep.trait; });
        for (const fp::SweepBlock& block : sweep.blocks) {
            EXPECT_EQ(block.worst & 0xff800000u, block.first);
            if (block.error == 0) continue;
            const fp::Judged judged = fp::judge(*trait, {block.worst, 0, 0, 0}, block.worstAnswer);
            EXPECT_LE(judged.error > block.error ? judged.error - block.error : block.error - judged.error, 1u)
                << sweep.trait << " at " << fp::floatText(block.worst);
        }
    }
}

// A device that fails while it is asked: the trait says so, and the others stand.
TEST_F(Planted, AFailureIsOfItsTraitAlone) {
    const std::unique_ptr<Device> small = DeviceEnvironment::open("storageRange=33554432");
    const fp::Fingerprint f = throughFile(fp::ask(*small, kFew));
    const std::vector<fp::Difference> found = fp::differences(sound(), f);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].trait, "large-indices");
    EXPECT_NE(found[0].right.find("the device allows 33554432 bytes"), std::string::npos) << found[0].right;
    EXPECT_FALSE(found[0].rightAllowed);
}

}  // namespace
}  // namespace plumb::test
