// SPDX-License-Identifier: MIT
// Products by other libraries, called as their users would call them. Compiled for the machine at hand by function clones (AVX-512, AVX2
// with FMA, baseline) where the compiler has them. Matrices are column-major here, as these libraries keep them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

namespace plumb::peers {

void glmVertices(const glm::mat4& m, std::span<const glm::vec4> in, std::span<glm::vec4> out);
void glmVertices7(const glm::mat4 (&m)[7], std::span<const glm::vec4> in, std::span<glm::vec4> out);  // m[0] first
glm::mat4 glmChain(std::span<const glm::mat4> chain);                                                 // chain[0] * chain[1] * ...

// Eigen can be used when `why` stays empty. Eigen is there when the build found its headers, OpenBLAS when its library is found now.
bool hasEigen(std::string& why);
void eigenVertices(const glm::mat4& m, std::span<const glm::vec4> in, std::span<glm::vec4> out);
bool hasOpenBlas(std::string& why);
void openBlasVertices(const glm::mat4& m, std::span<const glm::vec4> in, std::span<glm::vec4> out);  // on OpenBLAS's own threads

// Sum of all words. The result only keeps the compiler from leaving the reading out.
uint64_t sumWords(std::span<const uint64_t> words);

}  // namespace plumb::peers
