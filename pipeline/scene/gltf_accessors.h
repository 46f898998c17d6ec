// SPDX-License-Identifier: MIT
// Accessors of a glTF: elements of one type in a buffer, checked against the bytes that are there.
#pragma once

#include "pipeline/scene/gltf_buffers.h"
#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace plumb::gltf {

// Every element lies inside its buffer. Without data every element is 0, and none may be asked for.
struct Accessor {
    std::string location;
    const char* data = nullptr;
    size_t stride = 0;  // bytes from one element to the next
    size_t count = 0;
    int components = 1;
    int componentType = 0;  // glTF 3.6.2.2: 5120 is int8, to 5126, float
    bool normalized = false;
    std::shared_ptr<std::vector<char>> dense;  // owns `data` of a sparse accessor

    bool hasData() const { return data != nullptr; }
    size_t elementBytes() const;
    bool isIndex() const { return components == 1 && (componentType == 5121 || componentType == 5123 || componentType == 5125); }
    double component(size_t element, int i) const;
    uint32_t index(size_t element) const;
};

class Accessors {
public:
    Accessors(const Container& container, const Reading& reading);
    Accessor at(const Value& index);
    // Counts what the meshes ask for. Refused at `at` is more than kMaxCornersPerByte a byte that was read: such a file repeats its data to
    // fill our memory.
    void countCorners(uint64_t corners, const Value& at);

private:
    void overlaySparse(const Value& value, const Value& sparse, Accessor& accessor);

    std::vector<Value> accessors_;
    Buffers buffers_;
    uint64_t corners_ = 0;
};

}  // namespace plumb::gltf
