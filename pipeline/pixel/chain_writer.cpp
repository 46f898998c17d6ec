// SPDX-License-Identifier: MIT
#include "pipeline/pixel/chain_writer.h"

#include "pipeline/passes/illuminate.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace plumb {

Line& ChainWriter::add(const char* section, const std::string& name, const std::string& what) {
    Line line;
    line.section = section;
    line.name = name;
    line.what = what;
    chain_.lines.push_back(std::move(line));
    return chain_.lines.back();
}

Line& ChainWriter::twin(const char* section, const std::string& name, const std::string& what, std::vector<double> values,
                        std::vector<std::string> how) {
    Line& line = add(section, name, what);
    line.twin.values = std::move(values);
    line.how = std::move(how);
    return line;
}

Line* ChainWriter::find(const std::string& name) {
    const auto found = std::find_if(chain_.lines.begin(), chain_.lines.end(), [&](const Line& l) { return l.name == name; });
    return found == chain_.lines.end() ? nullptr : &*found;
}

void ChainWriter::take(const textbook::Values<float>& values) {
    for (Line& line : chain_.lines) {
        const auto found = values.find(line.name);
        if (found == values.end() || line.textbook.has()) continue;
        for (const float x : found->second) line.textbook.values.push_back(double(x));
    }
}

void ChainWriter::take(const textbook::Values<Interval>& values) {
    for (Line& line : chain_.lines) {
        const auto found = values.find(line.name);
        if (found == values.end() || line.truth.has()) continue;
        for (const Interval& x : found->second) {
            line.truth.values.push_back(x.middle());
            line.bound.push_back(x.bound());
        }
    }
}

void ChainWriter::close(const std::string& textbook, const std::string& device, const std::string& twin, const std::string& truth) {
    for (Line& line : chain_.lines) {
        const auto state = [](Column& column, const std::string& why) {
            if (!column.has() && column.why.empty()) column.why = why;
        };
        state(line.textbook, textbook);
        state(line.device, device);
        state(line.twin, twin);
        state(line.truth, truth);
    }
}

void ChainWriter::compare(bool deviceBounded) {
    for (const Line& line : chain_.lines) {
        const bool both = line.device.has() && line.twin.has();
        if (both && chain_.deviceParts.empty())
            for (size_t i = 0; i < std::min(line.device.values.size(), line.twin.values.size()); ++i) {
                const double a = line.device.values[i], b = line.twin.values[i];
                if (std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b)) continue;
                chain_.deviceParts = fmt::format("{} ({}): the device has {:.9g}, the twin {:.9g}{}", line.name, line.what, a, b,
                                                 deviceBounded ? "; the device's own functions draw" : "");
                break;
            }
        if (!line.decision || !line.twin.has() || !line.truth.has() || !chain_.truthParts.empty()) continue;
        const double decided = line.truth.values[0], slack = line.bound.empty() ? 0 : line.bound[0];
        if (slack == 0 && decided != line.twin.values[0])
            chain_.truthParts = fmt::format("{} ({}): the twin says {}, the truth {}", line.name, line.what,
                                            line.twin.values[0] != 0 ? "yes" : "no", decided != 0 ? "yes" : "no");
    }
}

namespace {

std::vector<std::string> each(const std::string& pattern) {
    std::vector<std::string> all;
    for (const char* i : {"0", "1", "2"}) {
        std::string text = pattern;
        for (size_t at = text.find('#'); at != text.npos; at = text.find('#')) text.replace(at, 1, i);
        all.push_back(text);
    }
    return all;
}

std::string dotOf(const std::string& a, const std::string& b) { return fmt::format("({0}[0]*{1}[0]+{0}[1]*{1}[1])+{0}[2]*{1}[2]", a, b); }

// Colour that one light adds with these reflectances, by the pass's function.
gpu::Colour added(const gpu::Toward& toward, const glm::vec4& intensity, const gpu::Surface& s, const gpu::Reflectance& k,
                  const gpu::ShadeParts& parts) {
    gpu::Colour c{0, 0, 0};
    gpu::addLightFrom(toward, intensity, s, k, parts, c);
    return c;
}

}  // namespace

gpu::Colour writeLit(ChainWriter& lines, const LitPoint& point, const std::string& prefix, const std::string& where) {
    const gpu::Surface& s = point.surface;
    const gpu::MaterialRecord& m = point.material;
    const gpu::Reflectance k = reflectanceOf(m);
    const auto name = [&](const char* what) { return prefix + what; };
    lines.twin("16.1", name("N"), "unit normal " + where, {s.nx, s.ny, s.nz});
    lines.twin("16.4", name("V"), "unit vector toward the viewer", {s.vx, s.vy, s.vz});
    lines.twin("16.3", name("Kd"), "diffuse reflectance", listOf(m.diffuse));
    lines.twin("16.4", name("Ks"), "specular reflectance", listOf(m.specular));
    lines.twin("16.4", name("specIndex"), "exponent of the highlight", {m.shininess});
    lines.twin("16.2", name("ambient"), "Ia Ka, and what the material emits", listOf(m.base));
    gpu::Colour sum{m.base.x, m.base.y, m.base.z};
    std::string last = name("ambient");
    for (size_t i = 0; i < point.lights.size(); ++i) {
        const gpu::LightRecord& light = point.lights[i];
        const std::string n = std::to_string(i);
        const auto own = [&](const char* what) { return prefix + what + n; };
        const double fading = light.kind == 0 ? 1 : std::pow(point.unit, double(light.attenuation));
        const glm::vec4 place(light.position, light.kind), intensity(light.intensity, light.attenuation), white(1, 1, 1, light.attenuation);
        const gpu::Toward t = gpu::towardLight(place, light.attenuation, point.parts.point, s.px, s.py, s.pz);
        const glm::vec3 l(t.x, t.y, t.z), normal(s.nx, s.ny, s.nz);
        lines.twin("16.3", own("L"), fmt::format("unit vector toward light {}", i), {t.x, t.y, t.z});
        lines.twin("16.3", own("fade"), "share that distance leaves, 1 / d^p", {double(t.fade) * fading});
        lines.twin("16.3", own("I"), "intensity of the light", listOf(glm::dvec3(light.intensity) / fading));
        const float cosine = gpu::dot3(normal, l);
        lines.twin("16.3", own("NL"), "N.L", {cosine}, {dotOf(name("N"), own("L"))});
        lines.add("16.4.2", own("R"), "light mirrored at the normal, 2 (N.L) N - L").twin.why = "the pass has |R - V|^2 / 2 in place of R";
        lines.add("16.4", own("RV"), "R.V").twin.why = "the pass has 1 - R.V = |R - V|^2 / 2";
        gpu::Toward full = t;
        full.fade = 1;
        const gpu::ShadeParts diffuse{true, false, point.parts.point, point.parts.power},
            specular{false, true, point.parts.point, point.parts.power};
        const gpu::Reflectance ones{1, 1, 1, 1, 1, 1, k.n, k.zeroPower};
        const std::string q = fmt::format("(({1}[0]+{1}[0])*{0}N[#]-{2}[#])-{0}V[#]", prefix, own("NL"), own("L"));
        const std::vector<std::string> qs = each(q);
        const std::string power = point.parts.power == gpu::kPowerExact     ? "power"
                                  : point.parts.power == gpu::kPowerSchlick ? "schlick"
                                                                            : "native";
        if (point.parts.specular)
            lines.twin("16.4", own("power"), "(R.V)^specIndex, 0 where N.L <= 0", {added(full, white, s, ones, specular).r},
                       {fmt::format("{}((({}),({}),({})),{},{})", power, qs[0], qs[1], qs[2], name("specIndex[0]"), own("NL") + "[0]")});
        const gpu::Colour d = added(t, intensity, s, {k.dr, k.dg, k.db, 0, 0, 0, k.n, k.zeroPower}, diffuse),
                          h = added(t, intensity, s, {0, 0, 0, k.sr, k.sg, k.sb, k.n, k.zeroPower}, specular);
        // The pass has both in its own unit of length, in which a faint product may underflow. The factor is a power of two.
        const std::string passFade = own("fade") + (fading == 1 ? "[0]" : fmt::format("[0]/{}", fading));
        const std::string passI = own("I") + (fading == 1 ? "[#]" : fmt::format("[#]*{}", fading));
        const std::string lit = fmt::format("max0({}[0])", own("NL"));
        const std::string faded = point.parts.point ? fmt::format("lit({}[0],{})", own("NL"), passFade) : passFade;
        if (point.parts.diffuse)
            lines.twin("16.3", own("diffuse"), "diffuse term, I Kd (N.L)", {d.r, d.g, d.b},
                       each(fmt::format("(({}[#]*{})*({}))*({})", name("Kd"), lit, faded, passI)));
        if (point.parts.specular)
            lines.twin("16.4", own("specular"), "specular term, I Ks (R.V)^specIndex", {h.r, h.g, h.b},
                       each(fmt::format("(({}[#]*{}[0])*({}))*({})", name("Ks"), own("power"), faded, passI)));
        gpu::addLightFrom(t, intensity, s, k, point.parts, sum);
        std::string both = point.parts.diffuse && point.parts.specular
                               ? fmt::format("({}[#]*{}+{}[#]*{}[0])", name("Kd"), lit, name("Ks"), own("power"))
                           : point.parts.diffuse ? fmt::format("({}[#]*{})", name("Kd"), lit)
                                                 : fmt::format("({}[#]*{}[0])", name("Ks"), own("power"));
        if (!point.parts.diffuse && !point.parts.specular) both = "0*" + name("Kd[#]");
        const bool end = i + 1 == point.lights.size();
        const std::string sumName = end ? name("sum") : own("partial");
        lines.twin("16.5", sumName, end ? "ambient + diffuse + specular of every light" : "sum so far", {sum.r, sum.g, sum.b},
                   each(fmt::format("{}[#]+({}*({}))*({})", last, both, faded, passI)));
        last = sumName;
    }
    if (point.lights.empty()) lines.twin("16.5", name("sum"), "ambient; no light shines", {sum.r, sum.g, sum.b}, each(last + "[#]"));
    return sum;
}

}  // namespace plumb
