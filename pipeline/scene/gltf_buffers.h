// SPDX-License-Identifier: MIT
// Buffers of a glTF and views of them: base64 in the file, a file beside it, or the binary chunk. Each is loaded when it is first used.
#pragma once

#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::gltf {

class Buffers {
public:
    Buffers(const Container& container, const Reading& reading);

    struct View {
        std::string_view bytes;
        size_t stride = 0;  // bytes from one element to the next; 0: not stated
    };
    View view(const Value& index);

    uint64_t bytesRead() const { return bytesRead_; }  // of the file and of those beside it, each once

private:
    std::string_view buffer(size_t i);
    std::string_view file(const Value& uri);

    const Container& container_;
    const Reading& reading_;
    std::vector<Value> buffers_, views_;
    std::vector<std::optional<std::string_view>> data_;  // a buffer
    std::vector<std::unique_ptr<std::string>> loaded_;   // owns what data_ shows
    std::map<std::string, std::string_view> files_;      // by path
    uint64_t bytesRead_ = 0;
};

}  // namespace plumb::gltf
