// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_value.h"

#include "host/error.h"
#include "pipeline/scene/text.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace plumb::gltf {

void Value::refuse(std::string_view text) const { throw inputError(location(), std::string(text)); }

std::string Value::location() const { return locationOfPointer(*file_, pointer_.empty() ? "/" : pointer_); }

std::optional<Value> Value::find(const char* key) const {
    wanted(node_->is_object(), "an object");
    const auto found = node_->find(key);
    if (found == node_->end()) return std::nullopt;
    return Value(*file_, *found, pointer_ + "/" + key);
}

Value Value::required(const char* key) const {
    if (auto value = find(key)) return *value;
    refuse(fmt::format("has no '{}'", key));
}

std::vector<Value> Value::list(const char* key) const {
    std::vector<Value> values;
    if (const auto array = find(key)) {
        values.reserve(array->size());
        for (size_t i = 0; i < array->size(); ++i) values.push_back(array->element(i));
    }
    return values;
}

size_t Value::size() const {
    wanted(node_->is_array(), "an array");
    return node_->size();
}

Value Value::element(size_t i) const { return Value(*file_, (*node_)[i], fmt::format("{}/{}", pointer_, i)); }

Value Value::elementOf(size_t i, size_t count) const {
    if (size() != count) refuse(fmt::format("has {} numbers, not {}", size(), count));
    return element(i);
}

bool Value::isObject() const { return node_->is_object(); }

std::vector<std::string> Value::keys() const {
    wanted(node_->is_object(), "an object");
    std::vector<std::string> names;
    for (const auto& [key, value] : node_->items()) {
        (void)value;
        names.push_back(key);
    }
    return names;
}

double Value::number(double least, double most) const {
    wanted(node_->is_number(), "a number");
    const double value = node_->get<double>();
    if (!std::isfinite(value)) refuse("is not finite");
    if (value < least || value > most) refuse(fmt::format("is {}, outside {:g} to {:g}", value, least, most));
    return value;
}

uint64_t Value::whole(uint64_t most) const {
    uint64_t value = 0;
    if (node_->is_number_unsigned()) {
        value = node_->get<uint64_t>();
    } else {
        const double real = node_->is_number_float() ? node_->get<double>() : -1;
        if (!(real >= 0 && real <= 0x1p53 && real == std::floor(real))) wanted(false, "a whole number");
        value = uint64_t(real);
    }
    if (value > most) refuse(fmt::format("is {}, above {}", value, most));
    return value;
}

size_t Value::index(size_t count, const char* what) const {
    const uint64_t value = whole(UINT64_MAX);
    if (value >= count) refuse(fmt::format("is {}, but there are {} {}", value, count, what));
    return size_t(value);
}

const std::string& Value::text() const {
    wanted(node_->is_string(), "a string");
    return node_->get_ref<const std::string&>();
}

bool Value::boolean() const {
    wanted(node_->is_boolean(), "true or false");
    return node_->get<bool>();
}

void Value::wanted(bool is, const char* kind) const {
    if (!is) refuse(fmt::format("is {}, not {}", described(), kind));
}

std::string Value::described() const {
    if (node_->is_number()) return printable(node_->dump(), 40);
    return node_->is_null()      ? "null"
           : node_->is_boolean() ? "a boolean"
           : node_->is_string()  ? "a string"
           : node_->is_array()   ? "an array"
                                 : "an object";
}

}  // namespace plumb::gltf
