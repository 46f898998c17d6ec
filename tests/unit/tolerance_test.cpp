// SPDX-License-Identifier: MIT
// What is not drawn never refuses a file: it is counted and named once, and --strict refuses it. The models of tests/data/models are of the
// kinds that public collections have; their table says what becomes of each. Further rows are written here.
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/scene.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

const fs::path kModels = fs::path(PLUMB_SOURCE_DIR) / "tests/data/models";

struct Outcome {
    std::string refusal;  // empty: loaded
    Scene scene;
};

Outcome outcomeOf(const fs::path& path, bool strict = false) {
    LoadOptions options;
    options.strict = strict;
    try {
        return {"", loadScene({path}, options)};
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input) << error.what();
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        EXPECT_STRNE(error.what(), "");
        return {error.what(), {}};
    }
}

size_t trianglesOf(const Scene& scene) {
    size_t count = 0;
    for (const Object& object : scene.objects) count += scene.meshes[object.mesh].triangles.size();
    return count;
}

// Box of the vertices that triangles have, in the world.
std::string boxOf(const Scene& scene) {
    glm::dvec3 low(1e30), high(-1e30);
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            const glm::dvec3 world(object.worldFromObject * glm::dvec4(mesh.statedAt(v), 1));
            low = glm::min(low, world);
            high = glm::max(high, world);
        }
    }
    return fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}", low.x, low.y, low.z, high.x, high.y, high.z);
}

std::string joined(const std::vector<std::string>& list) {
    std::string all;
    for (const std::string& entry : list) all += (all.empty() ? "" : ", ") + entry;
    return all.empty() ? "-" : all;
}

TEST(Tolerance, ModelsOfPublicKindsAreDrawnAndWhatIsNotIsNamed) {
    std::ifstream table(kModels / "expected.txt");
    std::set<std::string> rows;
    for (std::string line; std::getline(table, line);) {
        if (line.starts_with('#')) continue;
        std::vector<std::string> field;
        for (size_t at = 0; at <= line.size();) {
            const size_t end = std::min(line.find(" | ", at), line.size());
            field.push_back(line.substr(at, end - at));
            at = end + 3;
        }
        ASSERT_EQ(field.size(), 5u) << line;
        rows.insert(field[0]);
        const Outcome got = outcomeOf(kModels / field[0]), strict = outcomeOf(kModels / field[0], true);
        if (field[1] == "0") {
            EXPECT_NE(got.refusal.find(field[3]), std::string::npos) << line << "\n" << got.refusal;
            continue;
        }
        EXPECT_EQ(got.refusal, "") << line;
        EXPECT_EQ(fmt::format("{}", trianglesOf(got.scene)), field[1]) << line;
        EXPECT_EQ(boxOf(got.scene), field[2]) << line;
        EXPECT_EQ(got.scene.warnings.size(), field[3] == "-" ? 0u : 1u) << line << "\n" << joined(got.scene.warnings);
        const std::string words = field[3] == "-" ? "" : field[3];
        EXPECT_NE(joined(got.scene.warnings).find(words), std::string::npos) << joined(got.scene.warnings);
        EXPECT_EQ(joined(got.scene.ignored), field[4]) << line;
        EXPECT_EQ(strict.refusal.empty(), field[3] == "-" && field[4] == "-") << line << "\n" << strict.refusal;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(kModels)) {
        const std::string name = entry.path().filename().string();
        const bool model = entry.is_regular_file() && name != "expected.txt" && entry.path().extension() != ".mtl";
        EXPECT_EQ(rows.contains(name), model) << name;
    }
}

TEST(Tolerance, ColoursOfModelsAreThoseOfTheirLibraries) {
    const std::pair<const char*, glm::vec3> rows[] = {
        {"bom.obj", {1, 0, 0}}, {"mtllib-backslash.obj", {0, 1, 0}}, {"gltf-specular-glossiness.gltf", {1, 0.25f, 0}}};
    for (const auto& [name, colour] : rows) {
        const Scene scene = outcomeOf(kModels / name).scene;
        ASSERT_FALSE(scene.meshes.empty()) << name;
        EXPECT_EQ(scene.materials.at(scene.meshes[0].faceMaterial[0]).diffuse, colour) << name;
    }
}

const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", kObjFace = "f 1 2 3\n";
const std::string kFacet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
const std::string kPlyVertices = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kPlyFace = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPlyBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

// One triangle each: the file and what it is warned of.
struct Row {
    const char* name;
    std::string bytes, warning;
};

std::vector<Row> objRows() {
    return {
        {"a.obj", "\xef\xbb\xbf" + kObj + kObjFace, ""},
        {"a.obj", kObj + "f 1/ 2/ 3/\n", ":4:3: a face corner has more slashes than numbers; they are passed over (3 times)"},
        {"a.obj", kObj + "f 1/1/ 2/1/ 3/1/\nvt 0 0\n", "more slashes than numbers; they are passed over (3 times)"},
        {"a.obj", kObj + "vt 0 0\nvn 0 0 1\nf 1/1/1/1 2/1/1 3/1/1\n", ":6:3: a face corner has more slashes than numbers"},
        {"a.obj", kObj + "f 1/1 2/1 3/1\n", ":4:3: a face corner names a texture coordinate that is not there; it is not used (3 times)"},
        {"a.obj", kObj + "f 1/0 2/-7 3/x\n", "names a texture coordinate that is not there; it is not used (3 times)"},
        {"a.obj", kObj + "f 1//1 2//0 3//x\n", "names a normal that is not there; it counts as not stated (3 times)"},
        {"a.obj", kObj + "vn 0 nan 1\nf 1//1 2//1 3//1\n", ":4:6: a normal is not three finite numbers; it counts as not stated"},
        {"a.obj", kObj + "vn 0 1\n" + kObjFace, "a normal is not three finite numbers"},
        {"a.obj", kObj + "vt inf\n" + kObjFace, ":4:4: a texture coordinate is not finite numbers; it is not used"},
        {"a.obj", kObj + "v nan 0 0\nv 0 1e31 0\n" + kObjFace,
         ":4:3: a vertex that no face has is not finite; it is passed over (2 times)"},
        {"a.obj", kObj + "v 0 0 1 nan\nv 0 0 1 1 0\nv 0 0 1 1 2 3 4 5\n" + kObjFace, "no weight or colour; they are not used (3 times)"},
        {"a.obj", kObj + "f\nf 1\nf 3 9\n" + kObjFace, ":4:2: a face has fewer than 3 corners; it is not drawn (3 times)"},
        {"a.obj", "mtllib\n" + kObj + kObjFace, "'mtllib' names no material library; it is passed over"},
    };
}

std::vector<Row> stlRows() {
    const std::string solid = "solid s\n" + kFacet + "endsolid s\n";
    const auto changed = [&](const std::string& what, const std::string& with) {
        std::string text = solid;
        return text.replace(text.find(what), what.size(), with);
    };
    const std::string badNormal = "a facet normal is not three finite numbers; it is not used";
    return {
        {"a.stl", "\xef\xbb\xbf" + solid, ""},
        {"a.stl", "# a comment\n" + solid, ""},
        {"a.stl", changed("outer loop\n", "outer loop\n# a comment\n"), ""},
        {"a.stl", changed("endsolid s\n", "end solid s\n"), ""},
        {"a.stl", changed("endloop\nendfacet", "end loop\nEnd Facet"), ""},
        {"a.stl", changed("outer loop", "OuterLoop"), ""},
        {"a.stl", changed("endsolid s\n", ""), "a.stl:9:1: the file ends without 'endsolid'"},
        {"a.stl", changed("endsolid s\n", "end\n"), "a line outside the facets is no statement of STL; it is passed over"},
        {"a.stl", changed("solid s\n", "solid s\nsolid t\n"),
         "a.stl:2:1: 'solid' or 'endsolid' stands where none is expected; it is passed over"},
        {"a.stl", solid + "endsolid\n", "a.stl:10:1: 'solid' or 'endsolid' stands where none is expected; it is passed over"},
        {"a.stl", solid + "made by hand\n", "a.stl:10:1: a line outside the facets is no statement of STL; it is passed over"},
        {"a.stl", kFacet + "endsolid\n", "a.stl:1:1: 'facet' stands outside a solid; it is drawn"},
        {"a.stl", changed("normal 0 0 1", "normal nan inf 1"), badNormal},
        {"a.stl", changed("normal 0 0 1", "normal -nan(ind) 0 1"), badNormal},
        {"a.stl", changed("normal 0 0 1", "normal 0 0"), badNormal},
        {"a.stl", changed("normal 0 0 1", "0 0 1"), badNormal},
        {"a.stl", changed("endsolid", "facet normal 0 0 1 outer loop vertex 0 0 0 endloop endfacet\nendsolid"),
         "a facet has fewer than 3 corners; it is not drawn"},
    };
}

std::vector<Row> offRows() {
    const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    return {
        {"a.off", "\xef\xbb\xbfOFF\n3 1 0\n" + body, ""},
        {"a.off", "OFF3 1 0\n" + body, "a.off:1:1: the vertex count is glued to the word OFF"},
        {"a.off", "COFF3 1 0\n0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2\n", "the vertex count is glued to the word OFF"},
        {"a.off", "3 1 0\n" + body, "a.off:1:1: the word OFF is missing"},
        {"a.off", "OFF\n3 1 x\n" + body, "a.off:2:5: the edge count is not an integer; it is not used"},
        {"a.off", "OFF\n3 1 0\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2\n",
         "a.off:3:7: a vertex has more numbers than the header says; they are not used (3 times)"},
        {"a.off", "OFF\n3 1 0\n0 0 0 # first\n1 0 0 1 0 0\n0 1 0\n3 0 1 2\n", "a.off:4:7: a vertex has more numbers than the header says"},
        {"a.off", "OFF\n3 1 0\n0 0 0 1 0 0\n0 1 0\n3 0 1 2\n", ""},  // two vertices in a line
        {"a.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\nnan 0 0\n3 0 1 2\n", "a.off:6:1: a vertex that no face has is not finite"},
        {"a.off", "NOFF\n3 1 0\n0 0 0 nan 0 1\n1 0 0 0 inf 1\n0 1 0 0 0 1\n3 0 1 2\n",
         "a normal is not finite; it counts as not stated (2 times)"},
        {"a.off", "COFF\n3 1 0\n0 0 0 nan 0 0\n1 0 0\n0 1 0 1 0 red\n3 0 1 2\n", "it counts as not stated (3 times)"},
        {"a.off", "OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n1 0\n0\n3 0 1 2\n",
         "a face has fewer than 3 corners; it is not drawn (3 times)"},
        {"a.off", "OFF\n3 1 0\n" + body + "3 0 1 2\n", "a.off:7:1: data after the last face is ignored"},
    };
}

std::vector<Row> plyRows() {
    const auto vertexProperty = [](const std::string& more) { return kPlyVertices + more + kPlyFace; };
    std::string longBinary =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
        "property int64 id\nelement face 1\nproperty list uint64 int64 vertex_indices\nend_header\n";
    const auto word = [&](int64_t value) { longBinary.append(reinterpret_cast<const char*>(&value), 8); };
    for (const char* point : {"\0\0\0", "\1\0\0", "\0\1\0"}) longBinary.append(point, 3), word(-5);
    for (const int64_t value : {3, 0, 1, 2}) word(value);
    return {
        {"a.ply", "\xef\xbb\xbf" + kPlyVertices + kPlyFace + kPlyBody, ""},
        {"a.ply", longBinary, ""},
        {"a.ply", longBinary + "more", "4 bytes after the last element are ignored"},
        {"a.ply", kPlyVertices + "Created by hand\n" + kPlyFace + kPlyBody,
         "a.ply:7:1: a header line is no statement of PLY; it is passed over"},
        {"a.ply", kPlyVertices + kPlyFace + "comment c\n0 0 0\nobj_info 9\n1 0 0\n# d\n0 1 0\n3 0 1 2\n",
         "a.ply:10:1: a comment stands behind the header; it is passed over (3 times)"},
        {"a.ply", kPlyVertices + kPlyFace + kPlyBody + "7\n", "a.ply:14:1: data after the last element is ignored"},
        {"a.ply", kPlyVertices + kPlyFace + "0 0 0 9 9\n1 0 0 9 9\n0 1 0 9 9\n3 0 1 2 255 0 0\n",
         "a.ply:10:7: a row has more values than the header says; they are not used (4 times)"},
        {"a.ply", kPlyVertices + kPlyFace + "0 0 0 1 0 0\n0 1 0 3 0 1 2\n", ""},  // rows that share lines
        {"a.ply", vertexProperty("property int id\n") + "0 0 0 1.5\n1 0 0 x\n0 1 0 99999999999\n3 0 1 2\n",
         "a value that is not drawn is none of its type; it is passed over (3 times)"},
        {"a.ply",
         vertexProperty("property float nx\nproperty float ny\nproperty float nz\n") + "0 0 0 0 0 nan\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
         "a.ply:13:11: a normal is not finite; it counts as not stated"},
        {"a.ply",
         vertexProperty("property float red\nproperty float green\nproperty float blue\n") +
             "0 0 0 inf 0 0\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
         "a vertex colour is not finite; it counts as not stated"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n" + kPlyFace +
             "0 0 0\n1 0 0\n0 1 0\n0 nan inf\n3 0 1 2\n",
         "a.ply:13:3: a vertex that no face has is not finite; it is passed over"},
        {"a.ply",
         kPlyVertices + "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n2 0 9\n1 0\n0\n3 0 1 2\n",
         "a face has fewer than 3 corners; it is not drawn (3 times)"},
        {"a.ply",
         kPlyVertices + "element tristrips 2\nproperty list int int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n5 0 1 2 2 -1\n2 1 2\n",
         ""},
    };
}

TEST(Tolerance, EachReaderPassesOverWhatItDoesNotDraw) {
    std::vector<Row> rows;
    for (const auto& more : {objRows(), stlRows(), offRows(), plyRows()}) rows.insert(rows.end(), more.begin(), more.end());
    const TemporaryFolder folder;
    for (const Row& row : rows) {
        const fs::path path = folder.write(row.name, row.bytes);
        const Outcome got = outcomeOf(path);
        ASSERT_EQ(got.refusal, "") << row.bytes;
        EXPECT_EQ(trianglesOf(got.scene), 1u) << row.bytes;
        EXPECT_EQ(boxOf(got.scene), "0 0 0 1 1 0") << row.bytes;
        for (const glm::vec3& normal : got.scene.meshes.at(0).normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1)) << row.bytes;
        // One warning a row, but for the end of a solid that a row about something else has lost.
        std::vector<std::string> warnings = got.scene.warnings;
        EXPECT_TRUE(warnings.size() < 2 || joined(warnings).find("without 'endsolid'") != std::string::npos) << joined(warnings);
        EXPECT_EQ(warnings.empty(), row.warning.empty()) << row.bytes << joined(warnings);
        EXPECT_NE(joined(warnings).find(row.warning.empty() ? "-" : row.warning), std::string::npos) << joined(warnings) << "\n"
                                                                                                     << row.warning;
        EXPECT_EQ(outcomeOf(path, true).refusal.empty(), row.warning.empty() && got.scene.ignored.empty()) << row.bytes;
    }
}

std::string binaryStl(uint32_t stated, size_t facets, const std::string& more) {
    std::string bytes(80, 'h');
    const auto put = [&](const void* value, size_t size) { bytes.append(static_cast<const char*>(value), size); };
    put(&stated, 4);
    for (size_t f = 0; f < facets; ++f) {
        const float numbers[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, float(f)};
        put(numbers, sizeof numbers);
        bytes.append(2, '\0');
    }
    return bytes + more;
}

TEST(Tolerance, TheSizeOfABinaryStlDecidesWhereItIsThatOfWholeFacets) {
    const struct {
        uint32_t stated;
        size_t facets;
        std::string more;
        size_t drawn;  // 0: refused
        const char* words;
    } rows[] = {
        {0, 3, "", 3, "byte 80: facet count is 0, but 3 whole facets follow; they are drawn"},
        {1, 3, "", 3, "facet count is 1, but 3 whole facets follow"},
        {5, 3, "", 3, "facet count is 5, but 3 whole facets follow"},
        {3, 3, std::string(1, 'x'), 3, "byte 234: 1 bytes after the last facet are ignored"},
        {3, 3, std::string(100, '\0'), 3, "byte 234: 100 bytes after the last facet are ignored"},  // padding, no facets
        {3, 3, std::string(50, '\xff'), 3, "50 bytes after the last facet are ignored"},
        {4, 3, std::string(20, '\0'), 0, "byte 80: facet count is 4, which takes 284 bytes; the file has 254"},
        {0, 0, "", 0, "byte 80: facet count is 0: the file has no face"},
    };
    const TemporaryFolder folder;
    for (const auto& row : rows) {
        const fs::path path = folder.write("a.stl", binaryStl(row.stated, row.facets, row.more));
        const Outcome got = outcomeOf(path);
        EXPECT_EQ(trianglesOf(got.scene), row.drawn) << row.words;
        EXPECT_NE((got.refusal + joined(got.scene.warnings)).find(row.words), std::string::npos)
            << got.refusal << joined(got.scene.warnings);
        EXPECT_NE(outcomeOf(path, true).refusal, "");
    }
}

TEST(Tolerance, LibrariesAreFoundAsOtherSystemsWriteTheirPaths) {
    const TemporaryFolder folder;
    folder.write("sub/Paint.mtl", "\xef\xbb\xbfnewmtl red\nKd 1 0 0\n");
    folder.write("near.mtl", "newmtl red\nKd 1 0 0\n");
    for (const char* name : {"sub\\Paint.mtl", ".\\sub\\Paint.mtl", "SUB\\..\\near.mtl", "C:\\work\\near.mtl", "..\\near.mtl",
                             "\\\\host\\share\\NEAR.MTL", "sub/paint.MTL", "Near.mtl"}) {
        const fs::path path = folder.write("a.obj", fmt::format("mtllib {}\nusemtl red\n", name) + kObj + kObjFace);
        const Outcome got = outcomeOf(path);
        ASSERT_EQ(got.refusal, "") << name;
        EXPECT_EQ(got.scene.materials.at(0).diffuse, glm::vec3(1, 0, 0)) << name;
        EXPECT_NE(joined(got.scene.warnings).find("is read from '"), std::string::npos) << joined(got.scene.warnings);
        EXPECT_NE(outcomeOf(path, true).refusal, "") << name;
    }
    const Outcome missing = outcomeOf(folder.write("a.obj", "mtllib C:\\none.mtl\n" + kObj + kObjFace));
    EXPECT_NE(joined(missing.scene.warnings).find("material library 'C:\\none.mtl' is missing"), std::string::npos);
}

TEST(Tolerance, MaterialsThatNoFaceHasRefuseNothing) {
    const TemporaryFolder folder;
    folder.write("a.mtl", "newmtl bad\nKd nan 0 0\nnewmtl glow\nKd 0.5 0.5 0.5\nKe 1 1 1\nmap_Ke glow.png\n");
    const fs::path path = folder.write("a.obj", "mtllib a.mtl\nusemtl glow\n" + kObj + kObjFace);
    const Scene scene = outcomeOf(path).scene;
    ASSERT_EQ(scene.warnings.size(), 2u) << joined(scene.warnings);
    EXPECT_NE(scene.warnings[0].find("material 'glow': Ke is the factor of a texture that is not drawn; it is left out"),
              std::string::npos);
    EXPECT_NE(scene.warnings[1].find("material 'bad': a material that no face has cannot be read"), std::string::npos);
    EXPECT_EQ(scene.materials.at(0).emission, glm::vec3(0));
    EXPECT_NE(outcomeOf(folder.write("a.obj", "mtllib a.mtl\nusemtl bad\n" + kObj + kObjFace)).refusal.find("a.mtl:2:4: Kd red is NaN"),
              std::string::npos);
}

TEST(Tolerance, AFaceTooLargeToCutIsLeftOutAndCounted) {
    std::string text;
    for (int i = 0; i < 100000; ++i) text += fmt::format("v {} {} 0\n", i, i % 2);
    text += "v 99999 -5 0\nv 0 -5 0\nf 1 100002 100001\nf";
    for (int i = 100002; i > 0; --i) text += fmt::format(" {}", i);
    const TemporaryFolder folder;
    const fs::path path = folder.write("a.obj", text);
    const Outcome got = outcomeOf(path);
    EXPECT_EQ(trianglesOf(got.scene), 1u);
    EXPECT_NE(joined(got.scene.warnings).find("1 concave face has too many corners to triangulate: it is not drawn"), std::string::npos);
    EXPECT_NE(outcomeOf(path, true).refusal.find("face 1 is concave and has 100002 corners, too many to triangulate"), std::string::npos);
}

TEST(Tolerance, ALargeConcaveFaceIsCut) {
    std::string text;
    constexpr int kTeeth = 9000;
    for (int i = 0; i < kTeeth; ++i) text += fmt::format("v {} {} 0\n", i, i % 2);
    text += fmt::format("v {} -1 0\nv 0 -1 0\nf", kTeeth - 1);
    for (int i = kTeeth + 2; i > 0; --i) text += fmt::format(" {}", i);
    const TemporaryFolder folder;
    const Outcome got = outcomeOf(folder.write("a.obj", text));
    EXPECT_EQ(got.refusal, "");
    EXPECT_EQ(trianglesOf(got.scene), size_t(kTeeth));
    EXPECT_TRUE(got.scene.warnings.empty()) << joined(got.scene.warnings);
    // Twice the area of the triangles is that of the outline: no triangle lies outside, and none twice.
    double doubled = 0;
    const TriangleMesh& mesh = got.scene.meshes.at(0);
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.vertex[0]]), b(mesh.positions[t.vertex[1]]), c(mesh.positions[t.vertex[2]]);
        doubled += std::abs(glm::cross(b - a, c - a).z);
    }
    EXPECT_EQ(doubled, 3.0 * (kTeeth - 1));
}

}  // namespace
}  // namespace plumb
