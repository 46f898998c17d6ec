// SPDX-License-Identifier: MIT
// EXR through OpenEXR. The header is checked here first, because the library takes memory for what a header says.
#include "pipeline/compare/picture.h"
#include "pipeline/scene/text.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {
namespace {

constexpr int64_t kMostCoordinate = int64_t(1) << 24;  // limit of a data window
constexpr uint64_t kRowsOfABlock = 256;                // rows of a DWAB block; the other compressions have fewer
// limit of a block of rows or of a tile; OpenEXR takes memory for one block before it reads it
constexpr uint64_t kMostBlockBytes = uint64_t(1) << 28;
constexpr uint32_t kRowsAtOnce = 64;

class MemoryStream : public Imf::IStream {
public:
    explicit MemoryStream(std::string_view bytes) : Imf::IStream("picture"), bytes_(bytes) {}
    bool read(char to[], int n) override {
        if (n < 0 || uint64_t(n) > bytes_.size() - at_) throw std::runtime_error("the file ends early");
        std::memcpy(to, bytes_.data() + at_, size_t(n));
        at_ += uint64_t(n);
        return at_ < bytes_.size();
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t at) override {
        if (at > bytes_.size()) throw std::runtime_error("an offset lies outside the file");
        at_ = at;
    }

private:
    std::string_view bytes_;
    uint64_t at_ = 0;
};

// Sizes that the header states, found by walking over its attributes (OpenEXR file layout): name, type, size, value.
class HeaderWalk {
public:
    HeaderWalk(std::string_view bytes, const std::filesystem::path& path) : bytes_(bytes), path_(path) {}

    void check() {
        const uint32_t version = word(4);
        if ((version & 0xff) != 2) refuse(4, fmt::format("version {}; 2 is read", version & 0xff));
        if ((version & 0x1000) != 0) refuse(4, "several parts; one is read");
        if ((version & 0x800) != 0) refuse(4, "deep data; one sample a pixel is read");
        at_ = 8;
        int64_t box[4] = {};
        bool hasBox = false;
        uint64_t channels = 0, tileWidth = 0, tileHeight = 0;
        while (bytes_.substr(at_, 1) != std::string_view("\0", 1)) {
            const std::string_view name = text();
            text();
            const uint64_t size = word(at_), start = at_ + 4;
            if (size > bytes_.size() - start) refuse(at_, "an attribute is longer than the file");
            at_ = start;
            if (name == "dataWindow" && size == 16) {
                for (size_t i = 0; i < 4; ++i) box[i] = int32_t(word(start + 4 * i));
                hasBox = true;
            } else if (name == "tiles" && size == 9) {
                tileWidth = word(start);
                tileHeight = word(start + 4);
                if (tileWidth == 0 || tileHeight == 0 || tileWidth > kLargestPictureSide || tileHeight > kLargestPictureSide)
                    refuse(start, "tiles of a senseless size");
            } else if (name == "channels") {
                while (at_ < start + size && bytes_[at_] != '\0') {
                    text();
                    at_ += 16;  // type, linearity, samplings
                    ++channels;
                    if (at_ > start + size) refuse(start, "the list of channels runs over its end");
                }
            }
            at_ = start + size;
        }
        if (!hasBox || channels == 0) refuse(at_, "the data window or the channels are missing");
        for (const int64_t v : box)
            if (v < -kMostCoordinate || v > kMostCoordinate) refuse(at_, "the data window lies beyond 2^24");
        const int64_t width = box[2] - box[0] + 1, height = box[3] - box[1] + 1;
        if (width <= 0 || height <= 0) refuse(at_, "an empty data window");
        if (width > int64_t(kLargestPictureSide) || height > int64_t(kLargestPictureSide))
            refuse(at_, fmt::format("a side is longer than {}", kLargestPictureSide));
        if (channels > kMostChannels) refuse(at_, fmt::format("{} channels; at most {} are read", channels, kMostChannels));
        if (uint64_t(width) * uint64_t(height) * channels > kMostSamples) refuse(at_, "more than 2^27 samples");
        if ((version & 0x200) != 0 && tileWidth == 0) refuse(at_, "tiles without their size");
        const uint64_t blockWidth = std::max(uint64_t(width), tileWidth),
                       blockHeight = std::max(std::min(uint64_t(height), kRowsOfABlock), tileHeight);
        if (blockWidth * blockHeight * channels * 4 > kMostBlockBytes) refuse(at_, "a block of rows or a tile takes more than 256 MiB");
        // Each block has an offset of 8 bytes in the file's table; without tiles it holds 256 rows at most.
        const auto over = [](uint64_t count, uint64_t size) { return (count + size - 1) / size; };
        const uint64_t blocks =
            tileWidth == 0 ? over(uint64_t(height), kRowsOfABlock) : over(uint64_t(width), tileWidth) * over(uint64_t(height), tileHeight);
        if (blocks > (bytes_.size() - at_) / 8) refuse(bytes_.size(), "the file ends early");
    }

private:
    [[noreturn]] void refuse(uint64_t at, const std::string& why) const { throw inputError(locationOfByte(path_, at), "EXR: " + why); }
    uint32_t word(uint64_t at) const {
        if (bytes_.size() < 4 || at > bytes_.size() - 4) refuse(bytes_.size(), "the file ends within its header");
        uint32_t value = 0;
        std::memcpy(&value, bytes_.data() + at, 4);
        return value;
    }
    std::string_view text() {
        const size_t end = bytes_.find('\0', at_);
        if (end == bytes_.npos) refuse(bytes_.size(), "the file ends within its header");
        const std::string_view value = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        return value;
    }

    std::string_view bytes_;
    const std::filesystem::path& path_;
    uint64_t at_ = 0;
};

struct Group {
    std::string name;
    std::vector<std::string> channels;
    bool colour = false, alpha = false;
};

std::string nameOfDepth(const std::string& name) { return name == "Z" ? "depth" : name; }

// Groups of channels. "layer.R", "layer.G", "layer.B" (and A) are one colour, X Y Z of a layer one vector; a bare R G B A is "color", Y is
// its grey. Other channels are groups of one. A group has one type.
std::vector<Group> groupsOf(const Imf::ChannelList& list) {
    std::map<std::string, std::map<std::string, Imf::PixelType>> layers;
    for (auto it = list.begin(); it != list.end(); ++it) {
        const std::string name = it.name();
        const size_t dot = name.rfind('.');
        const std::string layer = dot == name.npos ? "" : name.substr(0, dot);
        layers[layer][dot == name.npos ? name : name.substr(dot + 1)] = it.channel().type;
    }
    std::vector<Group> groups;
    for (auto& entry : layers) {
        const std::string& layer = entry.first;
        std::map<std::string, Imf::PixelType>& channels = entry.second;
        const std::string prefix = layer.empty() ? "" : layer + ".";
        for (const std::string word : {"RGBA", "RGB", "XYZ", "YA", "Y"}) {
            const bool colour = word != "XYZ";
            if (!std::all_of(word.begin(), word.end(), [&](char c) { return channels.count(std::string(1, c)) != 0; })) continue;
            if ((word[0] == 'Y' || word[0] == 'X') && layer.empty() && channels.count("R") != 0) continue;
            const Imf::PixelType type = channels[std::string(1, word[0])];
            if (!std::all_of(word.begin(), word.end(), [&](char c) { return channels[std::string(1, c)] == type; })) continue;
            if (colour && type == Imf::UINT) continue;
            if (word == "XYZ" && layer.empty()) continue;  // Z alone is depth
            Group group;
            group.name = layer.empty() ? "color" : layer;
            group.colour = colour;
            group.alpha = word.back() == 'A';
            for (const char c : word) {
                group.channels.push_back(prefix + c);
                channels.erase(std::string(1, c));
            }
            groups.push_back(group);
            break;
        }
        for (const auto& [name, type] : channels) groups.push_back({nameOfDepth(prefix + name), {prefix + name}, false, false});
    }
    std::stable_partition(groups.begin(), groups.end(), [](const Group& g) { return g.name == "color"; });
    for (size_t i = 0; i < groups.size(); ++i)  // a channel "color" or "depth" beside those names keeps its own name
        for (size_t j = 0; j < i; ++j)
            if (groups[i].name == groups[j].name) groups[i].name += "'";
    return groups;
}

template <class T>
void append(const std::vector<std::vector<T>>& rows, size_t pixels, std::vector<double>& samples) {
    for (size_t i = 0; i < pixels; ++i)
        for (const std::vector<T>& channel : rows) samples.push_back(double(channel[i]));
}

// Inserts rows [y0, y0 + count) of every group; only these are read and kept at once.
template <class T>
void insert(Imf::FrameBuffer& buffer, Imf::PixelType type, const Group& group, std::vector<std::vector<T>>& rows, const Picture& picture,
            int y0, size_t count) {
    rows.assign(group.channels.size(), std::vector<T>(size_t(picture.width) * count));
    for (size_t c = 0; c < group.channels.size(); ++c) {
        // OpenEXR addresses pixel (x, y) of the data window as base + x * xStride + y * yStride.
        const ptrdiff_t before = ptrdiff_t(picture.left) + ptrdiff_t(y0) * ptrdiff_t(picture.width);
        char* base = reinterpret_cast<char*>(rows[c].data()) - before * ptrdiff_t(sizeof(T));
        buffer.insert(group.channels[c], Imf::Slice(type, base, sizeof(T), sizeof(T) * picture.width));
    }
}

Picture decode(Imf::InputFile& file) {
    Picture picture;
    picture.format = "exr";
    const Imath::Box2i& window = file.header().dataWindow();
    picture.left = window.min.x;
    picture.top = window.min.y;
    picture.width = uint32_t(window.max.x - window.min.x + 1);
    picture.height = uint32_t(window.max.y - window.min.y + 1);
    const Imf::ChannelList& list = file.header().channels();
    const std::vector<Group> groups = groupsOf(list);
    for (const Group& group : groups) {
        for (const std::string& name : group.channels)
            if (const Imf::Channel& channel = list[name.c_str()]; channel.xSampling != 1 || channel.ySampling != 1)
                throw std::runtime_error(fmt::format("channel '{}' is subsampled; one sample a pixel is read", printable(name, 40)));
        const Imf::PixelType type = list[group.channels[0].c_str()].type;
        Layer layer;
        layer.name = printable(group.name, 80);
        layer.kind = type == Imf::UINT ? LayerKind::id : LayerKind::real;
        layer.precision = type == Imf::HALF ? 16 : 32;
        layer.colour = layer.linear = group.colour;
        layer.alpha = layer.associated = group.alpha;
        layer.channels = uint32_t(group.channels.size());
        picture.layers.push_back(layer);
    }
    for (uint32_t y = 0; y < picture.height; y += kRowsAtOnce) {
        const size_t count = std::min(kRowsAtOnce, picture.height - y);
        const int y0 = picture.top + int(y);
        Imf::FrameBuffer buffer;
        std::vector<std::vector<std::vector<float>>> reals(groups.size());
        std::vector<std::vector<std::vector<uint32_t>>> ids(groups.size());
        for (size_t g = 0; g < groups.size(); ++g) {  // halves are widened, which is exact
            if (picture.layers[g].kind == LayerKind::id)
                insert(buffer, Imf::UINT, groups[g], ids[g], picture, y0, count);
            else
                insert(buffer, Imf::FLOAT, groups[g], reals[g], picture, y0, count);
        }
        file.setFrameBuffer(buffer);
        file.readPixels(y0, y0 + int(count) - 1);
        for (size_t g = 0; g < groups.size(); ++g) {
            append(reals[g], reals[g].empty() ? 0 : picture.width * count, picture.layers[g].samples);
            append(ids[g], ids[g].empty() ? 0 : picture.width * count, picture.layers[g].samples);
        }
    }
    return picture;
}

}  // namespace

Picture readExrPicture(const std::filesystem::path& path, const std::string& bytes) {
    HeaderWalk(bytes, path).check();
    try {
        Imf::Header::setMaxImageSize(int(kLargestPictureSide), int(kLargestPictureSide));
        Imf::Header::setMaxTileSize(int(kLargestPictureSide), int(kLargestPictureSide));
        MemoryStream stream(bytes);
        Imf::InputFile file(stream, 0);  // 0: decompress in this thread
        if (!file.isComplete()) throw std::runtime_error("the file is not complete");
        return decode(file);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw inputError(printablePath(path), "EXR: " + printable(e.what()));
    }
}

}  // namespace plumb
