// SPDX-License-Identifier: MIT
#include "tests/stress/scene_fuzz.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace plumb::test {

namespace {

using Point = std::array<double, 3>;
constexpr double kPi = 3.14159265358979323846;

// SplitMix64 (Steele, Lea and Flood 2014): the same numbers on every machine, and any seed is a good one.
class Dice {
public:
    Dice(uint64_t seed, uint64_t stream) : state_(mixed(seed + 0x9e3779b97f4a7c15u) ^ mixed(stream)) {}
    uint64_t next() { return mixed(state_ += 0x9e3779b97f4a7c15u); }
    uint32_t below(uint32_t n) { return uint32_t(next() >> 32) % n; }
    double real(double low, double high) { return low + (high - low) * (double(next() >> 11) * 0x1p-53); }
    bool chance(double share) { return real(0, 1) < share; }
    double magnitude(double lowest, double highest) { return std::pow(10.0, real(lowest, highest)); }  // decades
    template <class T>
    const T& of(const std::vector<T>& list) {
        return list[below(uint32_t(list.size()))];
    }
    Point direction() {
        for (;;) {
            const Point v{real(-1, 1), real(-1, 1), real(-1, 1)};
            const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            if (length > 0.1 && length < 1) return {v[0] / length, v[1] / length, v[2] / length};
        }
    }

private:
    static uint64_t mixed(uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        return x ^ (x >> 31);
    }
    uint64_t state_;
};

std::string number(double x) { return fmt::format("{:.17g}", x); }
std::string vector(const Point& p) { return fmt::format("[{}, {}, {}]", number(p[0]), number(p[1]), number(p[2])); }
Point moved(const Point& p, const Point& d, double by) { return {p[0] + d[0] * by, p[1] + d[1] * by, p[2] + d[2] * by}; }
Point times(const Point& p, double s) { return {p[0] * s, p[1] * s, p[2] * s}; }

enum class Kind { raster, ray, wire, notes, notesSpheres };

// What kernels are made for.
struct Family {
    Kind kind = Kind::raster;
    std::string shading = "phong";
    std::vector<std::string> settings, flags;
    uint32_t lights = 1, spheres = 0, planes = 0, meshes = 1;
    bool pointLights = false, specular = true, diffuse = true, mirrors = false, glass = false;
};

// Choices that do not exclude one another, of each axis of --trade.
std::string tradeOf(Dice& dice) {
    const std::vector<std::vector<const char*>> axes = {{"transform=fp64", "transform=block-integer"},
                                                        {"subpixel=4"},
                                                        {"interpolation=affine"},
                                                        {"depth=standard-32", "depth=24", "depth=16"},
                                                        {"normals=as-interpolated"},
                                                        {"light-vector=vertex", "light-vector=face", "light-vector=scene"},
                                                        {"specular=schlick", "specular=native"},
                                                        {"rate=1/2"},
                                                        {"encode=native"}};
    std::string words;
    for (uint32_t count = 1 + dice.below(3); count > 0; --count) {
        const std::vector<const char*>& axis = dice.of(axes);
        const std::string word = dice.of(axis), name = word.substr(0, word.find('='));
        if (words.find(name + "=") != words.npos) continue;
        const std::string both = words + word;
        const bool ownVectors = both.find("vector=vertex") != both.npos || both.find("vector=face") != both.npos;
        if (ownVectors && (both.find("native") != both.npos || both.find("rate") != both.npos)) continue;  // refused together
        words += (words.empty() ? "" : ",") + word;
    }
    return words;
}

// What the truth is compared with. Traced scenes have further numbers of lights and shapes, which no kernel is made for.
enum class Held { no, raster, rays };
Held heldOf(uint64_t index) { return index % kTruthEvery == 0 ? Held::raster : index % kTruthEvery == kRayTruthAt ? Held::rays : Held::no; }

Family familyOf(uint64_t seed, uint64_t index, Held held) {
    Family f;
    if (held == Held::rays) {
        f.kind = Kind::ray;
        f.shading = "ray";
        f.pointLights = f.mirrors = true;
        f.glass = index % 2 == 0;
        f.settings = {"shading = \"ray\""};
        return f;
    }
    if (held == Held::raster) {
        f.lights = 2;
        f.pointLights = true;
        f.meshes = 3;
        f.settings = {"shading = \"phong\""};
        return f;
    }
    Dice dice(seed, 2 * index + 1);
    const double which = dice.real(0, 1);
    f.kind = which < 0.56   ? Kind::raster
             : which < 0.76 ? Kind::ray
             : which < 0.86 ? Kind::wire
             : which < 0.97 ? Kind::notes
                            : Kind::notesSpheres;
    f.lights = dice.below(4);
    f.pointLights = dice.chance(0.6);
    f.specular = dice.chance(0.7);
    f.diffuse = !f.specular || dice.chance(0.9);
    f.meshes = 1 + dice.below(3);
    const std::string samples = fmt::format("--samples {}", dice.chance(0.7) ? 4 : 16);
    if (f.kind != Kind::notesSpheres && dice.chance(0.3)) f.flags.push_back(samples);
    if (dice.chance(0.15)) f.settings.emplace_back("encoding = \"linear\"");
    const std::vector<const char*> shadings = {"phong", "phong", "phong", "gouraud", "gouraud", "flat", "flat", "unlit"};
    f.shading = dice.of(shadings);
    switch (f.kind) {
        case Kind::raster:
            if (dice.chance(0.5)) f.flags.push_back("--trade " + tradeOf(dice));
            if (dice.chance(0.1)) f.settings.emplace_back("viewer = \"distant\"");
            break;
        case Kind::notes:
            f.settings.emplace_back("fill = \"notes\"");
            if (dice.chance(0.15)) f.settings.emplace_back("z_buffer = false");
            break;
        case Kind::notesSpheres:
            f.settings.emplace_back("fill = \"notes\"");
            f.shading = "phong";
            f.meshes = 0;
            f.spheres = 1 + dice.below(6);
            if (dice.chance(0.5)) f.settings.emplace_back("sphere_heights = \"whole\"");
            break;
        case Kind::wire: {
            f.shading = "wire";
            const std::vector<const char*> views = {"see-through", "culled", "solid"};
            f.settings.push_back(fmt::format("wire = \"{}\"", dice.of(views)));
            if (dice.chance(0.4)) f.settings.emplace_back("edges = \"polygons\"");
            break;
        }
        case Kind::ray: {
            f.shading = "ray";
            f.meshes = dice.chance(0.5) ? 1 + dice.below(2) : 0;
            f.spheres = dice.below(5);
            f.planes = dice.below(3);
            if (f.meshes + f.spheres + f.planes == 0) f.spheres = 1;
            f.mirrors = dice.chance(0.5);
            f.glass = dice.chance(0.4);
            const std::vector<const char*> samplings = {"grid", "grid", "centre", "random", "notes", "corners", "adaptive"};
            const std::string sampling = dice.of(samplings);
            if (sampling == "corners" || sampling == "adaptive") std::erase(f.flags, samples);
            f.settings.push_back(fmt::format("sampling = \"{}\"", sampling));
            f.settings.push_back(fmt::format("max_depth = {}", 1 + dice.below(6)));
            if (dice.chance(0.3)) f.settings.push_back(fmt::format("min_weight = {}", number(dice.magnitude(-3, -1))));
            if (dice.chance(0.2))
                f.settings.push_back(
                    fmt::format("jitter = {{ reflect = {}, shadow = {} }}", number(dice.real(0, 0.3)), number(dice.real(0, 0.3))));
            if (dice.chance(0.2)) f.settings.emplace_back("shadows = false");
            if (f.settings[0] == "encoding = \"linear\"" && dice.chance(0.5) && !f.glass) f.settings.emplace_back("levels = \"cut\"");
            break;
        }
    }
    f.settings.push_back(fmt::format("shading = \"{}\"", f.shading));
    return f;
}

// --- meshes, of size about 1 around the origin ------------------------------------------------------------------------------------------

FuzzScene::Mesh solid(Dice& dice) {
    FuzzScene::Mesh m;
    if (dice.chance(0.5)) {
        m.vertices = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
        m.faces = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {2, 3, 7, 6}, {1, 2, 6, 5}, {0, 4, 7, 3}};
        return m;
    }
    m.vertices = {{0, 0, 1.2}, {0, 0, -1.2}};
    const uint32_t around = 3 + dice.below(14);
    for (uint32_t i = 0; i < around; ++i) m.vertices.push_back({std::cos(2 * kPi * i / around), std::sin(2 * kPi * i / around), 0});
    for (uint32_t i = 0; i < around; ++i) {
        const uint32_t a = 2 + i, b = 2 + (i + 1) % around;
        m.faces.push_back({0, a, b});
        m.faces.push_back({1, b, a});
    }
    return m;
}

FuzzScene::Mesh sheet(Dice& dice) {
    FuzzScene::Mesh m;
    const uint32_t n = 1 + dice.below(6);
    const double bump = dice.chance(0.5) ? 0 : dice.real(0, 0.5);
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i)
            m.vertices.push_back({2.0 * i / n - 1, 2.0 * j / n - 1, bump * std::sin(5.0 * i / n) * std::cos(4.0 * j / n)});
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i;
            if (dice.chance(0.5))
                m.faces.push_back({a, a + 1, a + n + 2, a + n + 1});
            else
                m.faces.push_back({a, a + 1, a + n + 2}), m.faces.push_back({a, a + n + 2, a + n + 1});
        }
    return m;
}

FuzzScene::Mesh soup(Dice& dice, double thin) {
    FuzzScene::Mesh m;
    for (uint32_t count = 1 + dice.below(20); count > 0; --count) {
        const auto first = uint32_t(m.vertices.size());
        const Point a = times(dice.direction(), dice.real(0, 1)), d = dice.direction();
        m.vertices.push_back(a);
        m.vertices.push_back(moved(a, d, dice.real(0.1, 2)));
        m.vertices.push_back(moved(moved(a, d, dice.real(-1, 1)), dice.direction(), thin));
        m.faces.push_back({first, first + 1, first + 2});
    }
    return m;
}

// Corners on whole and half coordinates, some twice, so that edges, faces and depths tie.
FuzzScene::Mesh grid(Dice& dice, double step, int reach) {
    FuzzScene::Mesh m;
    const auto place = [&] { return step * (double(dice.below(uint32_t(2 * reach + 1))) - reach); };
    const bool level = dice.chance(0.7);
    for (uint32_t count = 1 + dice.below(16); count > 0; --count) {
        const auto first = uint32_t(m.vertices.size());
        for (int i = 0; i < 3; ++i) m.vertices.push_back({place(), place(), level ? 0.0 : place()});
        m.faces.push_back({first, first + 1, first + 2});
        if (dice.chance(0.2)) m.faces.push_back({first, first + 2, first + 1});
        if (dice.chance(0.2)) m.faces.push_back({first + 1, first + 2, first});
    }
    return m;
}

// A star: concave, one face.
FuzzScene::Mesh star(Dice& dice) {
    FuzzScene::Mesh m;
    m.faces.emplace_back();
    const uint32_t n = 2 * (3 + dice.below(5));
    for (uint32_t i = 0; i < n; ++i) {
        const double r = i % 2 ? 0.4 : 1;
        m.vertices.push_back({r * std::cos(2 * kPi * i / n), r * std::sin(2 * kPi * i / n), 0});
        m.faces[0].push_back(i);
    }
    return m;
}

FuzzScene::Mesh meshOf(Dice& dice) {
    switch (dice.below(8)) {
        case 0:
        case 1:
            return solid(dice);
        case 2:
        case 3:
            return sheet(dice);
        case 4:
            return soup(dice, dice.real(0.1, 1));
        case 5:
            return soup(dice, dice.magnitude(-8, -1));  // needles
        case 6:
            return grid(dice, 0.25, 6);
        default:
            return star(dice);
    }
}

// --- scenes -----------------------------------------------------------------------------------------------------------------------------

class Maker {
public:
    Maker(uint64_t seed, uint64_t index)
        : dice_(seed, 2 * index),
          truth_(heldOf(index) != Held::no),
          rays_(heldOf(index) == Held::rays),
          family_(familyOf(seed, index / kScenesOfFamily, heldOf(index))) {}

    FuzzScene make() {
        s_.settings = family_.settings;
        s_.flags = family_.flags;
        s_.heldAgainstTruth = truth_;
        s_.rays = rays_;
        if (rays_) {
            family_.lights = 1 + dice_.below(3);
            family_.meshes = 1 + dice_.below(2);
            family_.spheres = 1 + dice_.below(3);
            family_.planes = 1 + dice_.below(2);
            s_.settings.push_back(fmt::format("max_depth = {}", 1 + dice_.below(4)));
            if (dice_.chance(0.3)) s_.settings.push_back(fmt::format("min_weight = {}", number(dice_.magnitude(-3, -1))));
        }
        if (!truth_ && dice_.chance(0.25)) s_.flags.emplace_back("--background transparent");  // no kernel is made for it
        static const std::vector<std::pair<uint32_t, uint32_t>> kSizes = {{63, 17}, {48, 36}, {64, 48}, {33, 65}, {17, 9}, {80, 45},
                                                                          {16, 8},  {1, 1},   {1, 40},  {70, 1},  {97, 31}};
        std::tie(s_.width, s_.height) = dice_.of(kSizes);
        if (truth_) std::tie(s_.width, s_.height) = std::pair(24 + dice_.below(30), 20 + dice_.below(20));
        const bool isNotes = family_.kind == Kind::notes || family_.kind == Kind::notesSpheres;
        const bool pixels = family_.kind == Kind::notesSpheres || dice_.chance(isNotes ? 0.7 : 0.15);
        if (dice_.chance(0.8))
            s_.settings.push_back(
                fmt::format("background = [{}, {}, {}]", number(dice_.real(0, 1)), number(dice_.real(0, 1)), number(dice_.real(0, 1))));
        s_.settings.push_back(fmt::format("ambient = {}", number(dice_.chance(0.2) ? 0 : dice_.real(0, 1))));
        if (dice_.chance(0.3)) s_.settings.emplace_back("cull = false");
        if (family_.kind == Kind::ray) s_.settings.push_back(fmt::format("seed = {}", dice_.below(1000)));
        makeMaterials();
        pixels ? viewOfPixels() : viewOfSpace();
        for (uint32_t i = 0; i < family_.lights; ++i) makeLight();
        return std::move(s_);
    }

private:
    void makeMaterials() {
        for (const char* name : {"m0", "m1"}) {
            static const std::vector<double> kExponents = {0, 0.5, 1, 2, 5, 32, 100, 1000, 1e4, 1e6};
            const auto colour = [&](double most) { return vector({dice_.real(0, most), dice_.real(0, most), dice_.real(0, most)}); };
            std::string t = fmt::format(
                "[[material]]\nname = \"{}\"\nambient = {}\ndiffuse = {}\nspecular = {}\nemission = {}\nshininess = {}\n", name,
                colour(0.5), family_.diffuse ? colour(1) : "0", family_.specular ? colour(1) : "0", dice_.chance(0.2) ? colour(0.3) : "0",
                number(dice_.chance(0.7) ? dice_.of(kExponents) : dice_.magnitude(-1, 6)));
            const double reflect = family_.mirrors ? dice_.real(0.01, 0.5) : 0, transmit = family_.glass ? dice_.real(0.01, 0.49) : 0;
            if (family_.kind == Kind::ray)
                t += fmt::format("reflect = {}\ntransmit = {}\nior = {}\n", number(reflect), number(transmit),
                                 number(dice_.chance(0.3) ? 1 : dice_.real(0.5, 2.5)));
            s_.materials.push_back(t);
        }
    }

    std::string material() { return dice_.chance(0.5) ? "m0" : "m1"; }

    void add(FuzzScene::Mesh mesh, const std::string& transform) {
        mesh.name = fmt::format("mesh{}", s_.meshes.size());
        mesh.material = material();
        mesh.creaseDegrees = dice_.chance(0.3) ? 0 : dice_.chance(0.3) ? 180 : 60;
        s_.objects.push_back(fmt::format("[[object]]\nmesh = \"{}\"\ntransform = [{}]\n", mesh.name, transform));
        s_.meshes.push_back(std::move(mesh));
    }

    // The viewer of the notes: a unit a pixel, and coordinates that are whole, halves, or beside a power of two.
    void viewOfPixels() {
        s_.settings.emplace_back("handedness = \"left\"");
        const double distance = dice_.chance(0.5) ? 500 : double(1 + dice_.below(2000));
        s_.camera = fmt::format("distance = {}\n", number(distance));
        unit_ = std::max(s_.width, s_.height) / 2.0;
        toCentre_ = distance;
        for (uint32_t i = 0; i < family_.meshes; ++i) {
            const bool ties = dice_.chance(0.7);
            FuzzScene::Mesh mesh = ties ? grid(dice_, dice_.chance(0.5) ? 1 : 0.5, int(std::max(4.0, unit_ * 1.5))) : meshOf(dice_);
            if (!ties)
                for (Point& p : mesh.vertices) p = times(p, unit_ * dice_.real(0.2, 1));
            // The front of a left-handed scene runs the other way.
            for (std::vector<uint32_t>& face : mesh.faces) std::reverse(face.begin(), face.end());
            const double z = dice_.chance(0.5) ? 0 : std::floor(dice_.real(-0.9, 3) * distance);
            add(std::move(mesh), z == 0 ? "" : fmt::format("{{ translate = [0, 0, {}] }}", number(z)));
        }
        for (uint32_t i = 0; i < family_.spheres; ++i) {
            const auto whole = [&](double x) { return dice_.chance(0.5) ? std::floor(x) : x; };
            const Point centre{whole(dice_.real(-1, 1) * unit_), whole(dice_.real(-1, 1) * unit_), whole(dice_.real(0, 1) * 200)};
            s_.spheres.push_back(fmt::format("[[sphere]]\ncentre = {}\nradius = {}\nmaterial = \"{}\"\n", vector(centre),
                                             number(whole(dice_.real(1, 30))), material()));
        }
        makePlanes();
    }

    void viewOfSpace() {
        if (dice_.chance(0.2)) s_.settings.emplace_back("handedness = \"left\"");
        unit_ = dice_.chance(0.6) ? 1 : dice_.magnitude(-20, 20);
        const double fov = dice_.chance(0.5) ? dice_.real(20, 70) : dice_.magnitude(-1, std::log10(170.0));
        const double near = 1 / std::tan(fov * kPi / 360), distance = dice_.chance(0.1) ? dice_.real(0, 1) : near * dice_.real(0.8, 3) + 1;
        // Where all of it stands.
        if (dice_.chance(0.3)) centre_ = times(dice_.direction(), unit_ * dice_.magnitude(0, 7));
        const Point toEye = dice_.direction();
        const Point eye = moved(centre_, toEye, distance * unit_);
        Point at = moved(centre_, dice_.direction(), dice_.chance(0.5) ? 0 : 0.3 * unit_);
        if (dice_.chance(0.06)) at = moved(eye, toEye, distance * unit_);  // everything lies behind the viewer
        toCentre_ = distance * unit_;
        s_.camera = fmt::format("eye = {}\nat = {}\nup = {}\nfov = {}\n", vector(eye), vector(at), vector(dice_.direction()),
                                number(std::clamp(fov, 0.1, 170.0)));
        if (dice_.chance(0.15)) s_.camera += fmt::format("near = {}\n", number(distance * unit_ * dice_.magnitude(-4, 0)));
        for (uint32_t i = 0; i < family_.meshes; ++i) {
            FuzzScene::Mesh mesh = meshOf(dice_);
            // The scale is the vertices' or the matrix's; and so is an offset, which the one adds and the other takes away again.
            const double inVertices = dice_.chance(0.5) ? unit_ : 1;
            Point offset{0, 0, 0};
            if (dice_.chance(0.2)) offset = times(dice_.direction(), dice_.magnitude(0, 7));
            for (Point& p : mesh.vertices) p = times(moved(p, offset, 1), inVertices);
            std::string steps;
            const auto step = [&](const std::string& text) { steps += (steps.empty() ? "" : ", ") + text; };
            if (offset != Point{0, 0, 0}) step(fmt::format("{{ translate = {} }}", vector(times(offset, -inVertices))));
            if (inVertices != unit_) step(fmt::format("{{ scale = {} }}", number(unit_)));
            if (dice_.chance(0.2))
                step(fmt::format("{{ scale = {} }}", vector({dice_.real(0.1, 2), dice_.real(0.1, 2),
                                                             (dice_.chance(0.3) ? -1 : 1) * dice_.magnitude(-3, 0.3)})));
            if (dice_.chance(0.7))
                step(fmt::format("{{ rotate = {{ axis = {}, degrees = {} }} }}", vector(dice_.direction()),
                                 number(dice_.chance(0.3) ? 90.0 * dice_.below(4) : dice_.real(-180, 180))));
            step(fmt::format("{{ translate = {} }}", vector(moved(centre_, dice_.direction(), dice_.real(0, 0.8) * unit_))));
            add(std::move(mesh), steps);
        }
        for (uint32_t i = 0; i < family_.spheres; ++i)
            s_.spheres.push_back(fmt::format("[[sphere]]\ncentre = {}\nradius = {}\nmaterial = \"{}\"\n",
                                             vector(moved(centre_, dice_.direction(), dice_.real(0, 1.2) * unit_)),
                                             number(unit_ * (dice_.chance(0.1) ? dice_.magnitude(-3, 3) : dice_.real(0.1, 0.8))),
                                             material()));
        makePlanes();
    }

    void makePlanes() {
        for (uint32_t i = 0; i < family_.planes; ++i) {
            std::string t = fmt::format("[[plane]]\npoint = {}\nnormal = {}\nmaterial = \"m0\"\n",
                                        vector(moved(centre_, dice_.direction(), dice_.real(0, 1.5) * unit_)), vector(dice_.direction()));
            if (dice_.chance(0.5))
                t += fmt::format("u_range = [{}, {}]\n", number(-dice_.real(0.1, 3) * unit_), number(dice_.real(0.1, 3) * unit_));
            if (dice_.chance(0.5))
                t += fmt::format("board = {{ square = {}, material = \"m1\", mirrored = {} }}\n", number(unit_ * dice_.real(0.05, 1)),
                                 dice_.chance(0.5));
            if (dice_.chance(0.2)) t += "two_sided = false\n";
            s_.planes.push_back(t);
        }
    }

    void makeLight() {
        // As bright as a lamp is at the distance where it stands, or anything from 10^-8 to 10^3.
        const bool directional = !family_.pointLights || dice_.chance(0.3);
        const double colour = dice_.chance(0.7) ? dice_.real(0.1, 1) : dice_.magnitude(-8, 3);
        if (directional) {
            s_.lights.push_back(fmt::format("[[light]]\ntype = \"directional\"\ndirection = {}\nintensity = {}\n",
                                            vector(dice_.direction()), number(colour)));
            return;
        }
        const double away = unit_ * (dice_.chance(0.7) ? dice_.real(1, 5) : dice_.magnitude(-3, 3));
        const uint32_t power = dice_.below(3);
        static const std::array<const char*, 3> kNames = {"none", "1/d", "1/d^2"};
        const double intensity = colour * (dice_.chance(0.8) ? std::pow(away, power) : 1);
        s_.lights.push_back(fmt::format("[[light]]\ntype = \"point\"\nposition = {}\nintensity = {}\nattenuation = \"{}\"\n",
                                        vector(moved(centre_, dice_.direction(), away)), number(intensity), kNames[power]));
    }

    Dice dice_;
    const bool truth_, rays_;
    Family family_;
    FuzzScene s_;
    double unit_ = 1, toCentre_ = 1;  // scene units
    Point centre_{0, 0, 0};
};

}  // namespace

std::string FuzzScene::flagsText() const {
    std::string words = fmt::format("--size {}x{}", width, height);
    for (const std::string& flag : flags) words += " " + flag;
    return words;
}

std::string FuzzScene::text() const {
    std::string out = kFlagsLine + flagsText() + "\n";
    for (const std::string& line : settings) out += line + "\n";
    if (!camera.empty()) out += "\n[camera]\n" + camera;
    for (const auto* tables : {&materials, &lights})
        for (const std::string& table : *tables) out += "\n" + table;
    for (const Mesh& mesh : meshes) {
        out += fmt::format("\n[[mesh]]\nname = \"{}\"\nmaterial = \"{}\"\ncrease = {}\nvertices = [\n", mesh.name, mesh.material,
                           number(mesh.creaseDegrees));
        for (const Point& p : mesh.vertices) out += "  " + vector(p) + ",\n";
        out += "]\nfaces = [\n";
        for (const std::vector<uint32_t>& face : mesh.faces) {
            std::string corners;
            for (const uint32_t corner : face) corners += fmt::format("{}{}", corners.empty() ? "" : ", ", corner);
            out += fmt::format("  [{}],\n", corners);
        }
        out += "]\n";
    }
    for (const auto* tables : {&objects, &spheres, &planes})
        for (const std::string& table : *tables) out += "\n" + table;
    return out;
}

FuzzScene fuzzScene(uint64_t seed, uint64_t index) { return Maker(seed, index).make(); }

FuzzScene reduced(FuzzScene scene, const std::function<bool(const FuzzScene&)>& fails, uint32_t most) {
    uint32_t calls = 0;
    bool smaller = true;
    const auto keep = [&](const FuzzScene& candidate) {
        if (calls >= most) return false;
        ++calls;
        if (!fails(candidate)) return false;
        scene = candidate;
        return smaller = true;
    };
    const auto leaveOut = [&](auto member) {
        for (size_t i = (scene.*member).size(); i > 0; --i) {
            FuzzScene candidate = scene;
            (candidate.*member).erase((candidate.*member).begin() + ptrdiff_t(i - 1));
            keep(candidate);
        }
    };
    while (std::exchange(smaller, false)) {
        // An object takes its mesh with it: meshes that no object names would be drawn where they are.
        for (size_t i = scene.objects.size(); i > 0; --i) {
            FuzzScene candidate = scene;
            candidate.objects.erase(candidate.objects.begin() + ptrdiff_t(i - 1));
            if (scene.objects.size() == scene.meshes.size()) candidate.meshes.erase(candidate.meshes.begin() + ptrdiff_t(i - 1));
            keep(candidate);
        }
        leaveOut(&FuzzScene::spheres);
        leaveOut(&FuzzScene::planes);
        leaveOut(&FuzzScene::lights);
        leaveOut(&FuzzScene::flags);
        leaveOut(&FuzzScene::settings);
        leaveOut(&FuzzScene::materials);
        for (size_t m = 0; m < scene.meshes.size(); ++m) {
            // Halves first, then face by face.
            for (size_t count = scene.meshes[m].faces.size() / 2; count > 0; count /= 2)
                for (size_t first = 0; first + count <= scene.meshes[m].faces.size() && scene.meshes[m].faces.size() > 1;) {
                    FuzzScene candidate = scene;
                    auto& faces = candidate.meshes[m].faces;
                    faces.erase(faces.begin() + ptrdiff_t(first), faces.begin() + ptrdiff_t(first + count));
                    if (faces.empty() || !keep(candidate)) first += count;
                }
            FuzzScene candidate = scene;
            FuzzScene::Mesh& mesh = candidate.meshes[m];
            std::vector<uint32_t> place(mesh.vertices.size(), ~0u);
            std::vector<Point> used;
            for (std::vector<uint32_t>& face : mesh.faces)
                for (uint32_t& corner : face) {
                    if (place[corner] == ~0u) place[corner] = uint32_t(used.size()), used.push_back(mesh.vertices[corner]);
                    corner = place[corner];
                }
            if (used.size() < mesh.vertices.size()) {
                mesh.vertices = used;
                keep(candidate);
            }
        }
        for (uint32_t FuzzScene::*side : {&FuzzScene::width, &FuzzScene::height})
            for (uint32_t next : {scene.*side / 2, scene.*side - 1}) {
                if (next == 0 || next >= scene.*side) continue;
                FuzzScene candidate = scene;
                candidate.*side = next;
                keep(candidate);
            }
    }
    return scene;
}

}  // namespace plumb::test
