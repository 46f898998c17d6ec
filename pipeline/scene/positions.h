// SPDX-License-Identifier: MIT
// Positions from a reader, in binary64.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

// Binary64 numbers in the memory of float32 for as long as float32 holds each of them exactly. Most large files are files of float32.
class Positions {
public:
    using value_type = glm::dvec3;
    Positions() = default;
    Positions(const std::vector<glm::vec3>& positions) : narrow_(positions) {}  // NOLINT(google-explicit-constructor): the same numbers

    size_t size() const { return narrow_.size() + wide_.size(); }
    bool empty() const { return size() == 0; }
    void reserve(size_t count) { wide_.empty() ? narrow_.reserve(count) : wide_.reserve(count); }
    glm::dvec3 operator[](size_t i) const { return wide_.empty() ? glm::dvec3(narrow_[i]) : wide_[i]; }

    void push_back(const glm::dvec3& p) {
        if (wide_.empty() && glm::dvec3(glm::vec3(p)) == p)
            narrow_.push_back(glm::vec3(p));
        else
            widened().push_back(p);
    }
    void set(size_t i, const glm::dvec3& p) { widened()[i] = p; }
    void release() { *this = Positions(); }  // gives the memory back

    bool operator==(const Positions& other) const {
        if (size() != other.size()) return false;
        for (size_t i = 0; i < size(); ++i)
            if ((*this)[i] != other[i]) return false;
        return true;
    }

private:
    std::vector<glm::dvec3>& widened() {
        if (!narrow_.empty() || wide_.empty()) {
            wide_.reserve(narrow_.capacity());
            wide_.assign(narrow_.begin(), narrow_.end());
            narrow_ = std::vector<glm::vec3>();
        }
        return wide_;
    }

    std::vector<glm::vec3> narrow_;  // one of the two is empty
    std::vector<glm::dvec3> wide_;
};

}  // namespace plumb
