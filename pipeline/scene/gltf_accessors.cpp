// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_accessors.h"

#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <string_view>

namespace plumb::gltf {

static_assert(std::endian::native == std::endian::little, "binary glTF is read as it lies in memory");

// One byte of indices makes at most three corners (a strip), and one accessor may serve a few primitives.
static constexpr uint64_t kMaxCornersPerByte = 16;
static constexpr uint64_t kMaxCorners = uint64_t(1) << 62;  // more are not told apart

static size_t bytesOfComponent(int componentType) {
    switch (componentType) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
    }
}

template <class T>
static T loadAs(const char* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

// glTF 3.6.2.2 and, for normalized integers, KHR_mesh_quantization.
double Accessor::component(size_t element, int i) const {
    const char* at = data + element * stride + size_t(i) * bytesOfComponent(componentType);
    switch (componentType) {
        case 5120:
            return normalized ? std::max(loadAs<int8_t>(at) / 127.0, -1.0) : loadAs<int8_t>(at);
        case 5121:
            return normalized ? loadAs<uint8_t>(at) / 255.0 : loadAs<uint8_t>(at);
        case 5122:
            return normalized ? std::max(loadAs<int16_t>(at) / 32767.0, -1.0) : loadAs<int16_t>(at);
        case 5123:
            return normalized ? loadAs<uint16_t>(at) / 65535.0 : loadAs<uint16_t>(at);
        case 5125:
            return loadAs<uint32_t>(at);
        default:
            return loadAs<float>(at);
    }
}

uint32_t Accessor::index(size_t element) const {
    const char* at = data + element * stride;
    return componentType == 5121 ? loadAs<uint8_t>(at) : componentType == 5123 ? loadAs<uint16_t>(at) : loadAs<uint32_t>(at);
}

size_t Accessor::elementBytes() const { return bytesOfComponent(componentType) * size_t(components); }

Accessors::Accessors(const Container& container, const Reading& reading)
    : accessors_(container.root().list("accessors")), buffers_(container, reading) {}

void Accessors::countCorners(uint64_t corners, const Value& at) {
    corners_ = std::min(corners_ + std::min(corners, kMaxCorners), kMaxCorners);
    if (corners_ > kMaxCornersPerByte * buffers_.bytesRead())
        at.refuse(fmt::format("the meshes ask for {} corners of {} bytes, more than {} a byte", corners_, buffers_.bytesRead(),
                              kMaxCornersPerByte));
}

Accessor Accessors::at(const Value& index) {
    const Value& value = accessors_[index.index(accessors_.size(), "accessors")];
    Accessor result;
    result.location = value.location();
    const Value typeValue = value.required("type");
    const std::string& type = typeValue.text();
    static const std::map<std::string, int> kComponents{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                        {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    const auto known = kComponents.find(type);
    if (known == kComponents.end()) typeValue.refuse(fmt::format("'{}' is no type of accessor", printable(type, 40)));
    result.components = known->second;
    const Value componentValue = value.required("componentType");
    result.componentType = int(componentValue.whole(65535));
    const size_t elementBytes = result.elementBytes();
    if (elementBytes == 0) componentValue.refuse(fmt::format("is {}, no component type", result.componentType));
    if (const auto normalized = value.find("normalized")) result.normalized = normalized->boolean();
    const Value countValue = value.required("count");
    const uint64_t count = countValue.whole(UINT64_MAX);
    result.count = size_t(count);
    if (count == 0) return result;
    if (const auto viewIndex = value.find("bufferView")) {
        const Buffers::View view = buffers_.view(*viewIndex);
        const std::string_view data = view.bytes;
        result.stride = view.stride == 0 ? elementBytes : view.stride;
        if (result.stride < elementBytes) value.refuse(fmt::format("elements of {} bytes lie {} apart", elementBytes, result.stride));
        const auto offsetValue = value.find("byteOffset");
        const uint64_t offset = offsetValue ? offsetValue->whole(kMaxFileBytes) : 0;
        // offset + stride * (count - 1) + elementBytes <= data.size(), without overflow
        if (offset > data.size() || elementBytes > data.size() - offset ||
            count - 1 > (data.size() - offset - elementBytes) / result.stride)
            countValue.refuse(
                fmt::format("is {}: {} bytes an element at {} of a view of {} bytes", count, result.stride, offset, data.size()));
        result.data = data.data() + offset;
    }
    if (const auto sparse = value.find("sparse")) overlaySparse(value, *sparse, result);
    return result;
}

// glTF 3.6.2.3.
void Accessors::overlaySparse(const Value& value, const Value& sparse, Accessor& accessor) {
    const size_t elementBytes = accessor.elementBytes();
    const Value countValue = sparse.required("count"), indices = sparse.required("indices"), values = sparse.required("values");
    const uint64_t count = countValue.whole(accessor.count);
    const auto slice = [&](const Value& part, size_t bytes) {
        const std::string_view data = buffers_.view(part.required("bufferView")).bytes;
        const auto offsetValue = part.find("byteOffset");
        const uint64_t offset = offsetValue ? offsetValue->whole(kMaxFileBytes) : 0;
        if (offset > data.size() || count > (data.size() - offset) / bytes)
            countValue.refuse(fmt::format("is {}, more than {} bytes hold", count, data.size()));
        return data.data() + offset;
    };
    const Value typeValue = indices.required("componentType");
    Accessor where;
    where.componentType = int(typeValue.whole(65535));
    if (!where.isIndex()) typeValue.refuse(fmt::format("is {}, no type of index", where.componentType));
    where.stride = where.elementBytes();
    where.data = slice(indices, where.stride);
    const char* what = slice(values, elementBytes);

    countCorners(accessor.count, value);
    auto dense = std::make_shared<std::vector<char>>(accessor.count * elementBytes);
    for (size_t i = 0; i < accessor.count && accessor.hasData(); ++i)
        std::memcpy(dense->data() + i * elementBytes, accessor.data + i * accessor.stride, elementBytes);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t element = where.index(i);
        if (element >= accessor.count) indices.refuse(fmt::format("element {} is {}, but the accessor has {}", i, element, accessor.count));
        std::memcpy(dense->data() + element * elementBytes, what + i * elementBytes, elementBytes);
    }
    accessor.dense = dense;
    accessor.data = dense->data();
    accessor.stride = elementBytes;
}

}  // namespace plumb::gltf
