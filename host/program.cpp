// SPDX-License-Identifier: MIT
// Reflection of SPIR-V words and the pipelines made from them.
// SPIR-V 1.5 specification: 2.3 physical layout, 3.32 instructions, 3.20 decorations.
#include "host/fold.h"
#include "host/spirv_words.h"
#include "host/vulkan.h"

#include <fmt/format.h>
#include <cstdint>

#include <algorithm>
#include <functional>
#include <future>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {

namespace {

enum Decoration : uint32_t {
    kSpecId = 1,
    kBufferBlock = 3,
    kArrayStride = 6,
    kMatrixStride = 7,
    kBuiltIn = 11,
    kNonWritable = 24,
    kNonReadable = 25,
    kBinding = 33,
    kDescriptorSet = 34,
    kOffset = 35,
};
constexpr uint32_t kExecutionModelGlCompute = 5, kLocalSize = 17, kLocalSizeId = 38, kBuiltInWorkgroupSize = 25;
constexpr uint32_t kUniformConstant = 0, kUniform = 2, kPushConstant = 9, kStorageBuffer = 12;
constexpr uint32_t kDimBuffer = 5;
constexpr uint32_t kWholeType = ~0u;  // "member" of decorations on the id itself

class ModuleReader {
public:
    explicit ModuleReader(const Module& module) : name_(module.name), words_(module.words) { index(); }

    // Specialization constants of the module, by rising constant_id: number and name.
    std::vector<std::pair<uint32_t, std::string>> specialized() const {
        std::vector<std::pair<uint32_t, std::string>> found;
        for (const auto& [key, value] : decorations_)
            if (key.decoration == kSpecId) found.emplace_back(value, nameOfConstant(key.id));
        std::sort(found.begin(), found.end());
        return found;
    }

    Reflection reflection(const ConstantsById& constants) {
        constants_ = constants;
        Reflection result;
        localSize(result);
        for (const uint32_t variable : variables_) addVariable(variable, result);
        std::sort(result.bindings.begin(), result.bindings.end(), [](const auto& a, const auto& b) { return a.binding < b.binding; });
        for (size_t i = 1; i < result.bindings.size(); ++i)
            if (result.bindings[i].binding == result.bindings[i - 1].binding) fail("two variables share a binding");
        for (const auto& [id, name] : specialized()) {
            result.specializationIds.push_back(id);
            result.specializationNames.push_back(name);
        }
        return result;
    }

private:
    struct DecorationKey {
        uint32_t id, member, decoration;
        auto operator<=>(const DecorationKey&) const = default;
    };
    using Instruction = std::span<const uint32_t>;  // word 0 is opcode and count

    [[noreturn]] void fail(const std::string& what) const {
        throw deviceError(fmt::format("{}: not a compute module that this reader understands: {}", name_, what));
    }

    void index() {
        if (words_.size() < kHeaderWords || words_[0] != kSpirvMagic) fail("no SPIR-V header");
        size_t entryPoints = 0;
        for (size_t at = kHeaderWords; at < words_.size();) {
            const uint32_t op = words_[at] & 0xffffu, count = words_[at] >> 16;
            if (count == 0 || at + count > words_.size()) fail(fmt::format("truncated at word {}", at));
            const Instruction in = words_.subspan(at, count);
            at += count;
            const auto atLeast = [&](uint32_t n) {
                if (count < n) fail(fmt::format("short instruction {}", op));
            };
            switch (op) {
                case kOpName:
                    atLeast(3);
                    names_[in[1]] = text(in.subspan(2));
                    break;
                case kOpEntryPoint:
                    atLeast(4);
                    if (in[1] != kExecutionModelGlCompute) fail("an entry point that is not compute");
                    ++entryPoints;
                    break;
                case kOpExecutionMode:
                case kOpExecutionModeId:
                    atLeast(3);
                    if (in[2] == kLocalSize || in[2] == kLocalSizeId) {
                        atLeast(6);
                        sizeMode_ = in;
                    }
                    break;
                case kOpDecorate:
                    atLeast(3);
                    decorations_[{in[1], kWholeType, in[2]}] = count > 3 ? in[3] : 1u;
                    break;
                case kOpMemberDecorate:
                    atLeast(4);
                    decorations_[{in[1], in[2], in[3]}] = count > 4 ? in[4] : 1u;
                    break;
                case kOpTypeInt:
                case kOpTypeFloat:
                case kOpTypeVector:
                case kOpTypeMatrix:
                case kOpTypeImage:
                case kOpTypeSampledImage:
                case kOpTypeArray:
                case kOpTypeRuntimeArray:
                case kOpTypeStruct:
                case kOpTypePointer:
                    atLeast(2);
                    ids_[in[1]] = in;
                    break;
                case kOpConstant:
                case kOpConstantComposite:
                case kOpSpecConstantTrue:
                case kOpSpecConstantFalse:
                case kOpSpecConstant:
                case kOpSpecConstantComposite:
                    atLeast(3);
                    ids_[in[2]] = in;
                    break;
                case kOpVariable:
                    atLeast(4);
                    ids_[in[2]] = in;
                    variables_.push_back(in[2]);
                    break;
                case kOpFunction:
                    at = words_.size();
                    break;  // bodies have nothing to reflect
                default:
                    break;
            }
        }
        if (entryPoints != 1) fail(fmt::format("{} entry points", entryPoints));
    }

    static std::string text(Instruction words) {
        std::string result;
        for (const uint32_t word : words)
            for (int byte = 0; byte < 4; ++byte) {
                const char c = char(word >> (8 * byte) & 0xffu);
                if (c == 0) return result;
                result += c;
            }
        return result;
    }
    std::string nameOf(uint32_t id) const {
        const auto it = names_.find(id);
        return it == names_.end() ? std::string() : it->second;
    }
    // Name of a constant. glslang gives the constants of local_size_x_id, ... none.
    std::string nameOfConstant(uint32_t id) const {
        constexpr const char* kSizes[] = {"kLocalSizeX", "kLocalSizeY", "kLocalSizeZ"};
        if (std::string name = nameOf(id); !name.empty()) return name;
        const std::span<const uint32_t> sizes = sizeIds();
        for (size_t i = 0; i < sizes.size(); ++i)
            if (sizes[i] == id) return kSizes[i];
        return "";
    }
    static uint32_t opOf(Instruction in) { return in[0] & 0xffffu; }
    Instruction definition(uint32_t id, size_t words) const {
        const auto it = ids_.find(id);
        if (it == ids_.end() || it->second.size() < words) fail(fmt::format("id %{} is not of a known kind", id));
        return it->second;
    }
    std::optional<uint32_t> decoration(uint32_t id, uint32_t decoration, uint32_t member = kWholeType) const {
        const auto it = decorations_.find({id, member, decoration});
        return it == decorations_.end() ? std::nullopt : std::optional(it->second);
    }

    uint32_t constantValue(uint32_t id) const {
        const Instruction in = definition(id, 3);
        if (const auto spec = decoration(id, kSpecId))
            if (const auto given = constants_.find(*spec); given != constants_.end()) return given->second;
        switch (opOf(in)) {
            case kOpSpecConstantTrue:
                return 1;
            case kOpSpecConstantFalse:
                return 0;
            case kOpConstant:
            case kOpSpecConstant:
                if (in.size() >= 4) return in[3];
                [[fallthrough]];
            default:
                fail(fmt::format("constant %{} is computed", id));
        }
    }

    // Constants of the workgroup's size, three; empty where it is three literals. A constant decorated WorkgroupSize
    // overrides the execution mode; glslang writes it for local_size_x_id.
    Instruction sizeIds() const {
        for (const auto& [key, value] : decorations_)
            if (key.decoration == kBuiltIn && key.member == kWholeType && value == kBuiltInWorkgroupSize)
                return definition(key.id, 6).subspan(3, 3);
        return sizeMode_[2] == kLocalSizeId ? sizeMode_.subspan(3, 3) : Instruction();
    }

    void localSize(Reflection& result) const {
        if (sizeMode_.empty()) fail("no local size");
        const Instruction ids = sizeIds();
        for (size_t i = 0; i < 3; ++i) result.localSize[i] = ids.empty() ? sizeMode_[3 + i] : constantValue(ids[i]);
    }

    // Bytes of a type inside a block with explicit layout; `structId`/`member` locate its MatrixStride.
    uint32_t sizeOf(uint32_t type, uint32_t structId = 0, uint32_t member = 0, int depth = 0) const {
        if (depth > 16) fail("types nested too deep");
        const Instruction in = definition(type, 2);
        switch (opOf(in)) {
            case kOpTypeInt:
            case kOpTypeFloat:
                return definition(type, 3)[2] / 8;
            case kOpTypeVector:
                return definition(type, 4)[3] * sizeOf(in[2], 0, 0, depth + 1);
            case kOpTypeMatrix: {
                const auto stride = decoration(structId, kMatrixStride, member);
                if (!stride) fail("a matrix without stride");
                return *stride * (definition(type, 4)[3] - 1) + sizeOf(in[2], 0, 0, depth + 1);
            }
            case kOpTypeArray: {
                const auto stride = decoration(type, kArrayStride);
                if (!stride) fail("an array without stride");
                return *stride * constantValue(definition(type, 4)[3]);
            }
            case kOpTypeStruct: {
                uint32_t end = 0;
                for (uint32_t i = 0; i + 2 < in.size(); ++i) {
                    const auto offset = decoration(type, kOffset, i);
                    if (!offset) fail("a block member without offset");
                    end = std::max(end, *offset + sizeOf(in[2 + i], type, i, depth + 1));
                }
                return end;
            }
            case kOpTypePointer:
                return 8;
            default:
                fail(fmt::format("a block member of kind {}", opOf(in)));
        }
    }

    bool allMembers(uint32_t type, uint32_t wanted) const {
        const Instruction in = definition(type, 2);
        for (uint32_t i = 0; i + 2 < in.size(); ++i)
            if (!decoration(type, wanted, i)) return false;
        return in.size() > 2;
    }

    void addVariable(uint32_t id, Reflection& result) const {
        const Instruction variable = definition(id, 4);
        const uint32_t storageClass = variable[3];
        const uint32_t type = definition(variable[1], 4)[3];  // type that the pointer points to
        if (storageClass == kPushConstant) {
            result.pushConstantBytes = sizeOf(type);
            return;
        }
        if (storageClass != kUniformConstant && storageClass != kUniform && storageClass != kStorageBuffer) return;
        ReflectedBinding binding;
        binding.name = nameOf(id).empty() ? nameOf(type) : nameOf(id);
        const auto number = decoration(id, kBinding);
        if (!number) fail(fmt::format("'{}' has no binding", binding.name));
        if (decoration(id, kDescriptorSet).value_or(0) != 0) fail(fmt::format("'{}' is not in set 0", binding.name));
        binding.binding = *number;
        const Instruction in = definition(type, 2);
        if (storageClass == kUniformConstant) {
            const Instruction image = opOf(in) == kOpTypeSampledImage ? definition(definition(type, 3)[2], 9) : in;
            if (opOf(image) != kOpTypeImage || image.size() < 9 || image[3] != kDimBuffer || image[7] != 1)
                fail(fmt::format("'{}' is an image that is not a uniform texel buffer", binding.name));
            const Instruction texel = definition(image[2], 3);
            binding.kind = BindingKind::uniformTexel;
            binding.texel = opOf(texel) == kOpTypeFloat       ? TexelType::floating
                            : definition(image[2], 4)[3] == 0 ? TexelType::unsignedInt
                                                              : TexelType::signedInt;
        } else {
            if (opOf(in) != kOpTypeStruct || in.size() < 3) fail(fmt::format("'{}' is an array of blocks or empty", binding.name));
            const bool storage = storageClass == kStorageBuffer || decoration(type, kBufferBlock);
            binding.kind = storage ? BindingKind::storage : BindingKind::uniformBuffer;
            const Instruction last = definition(in.back(), 2);
            if (opOf(last) == kOpTypeRuntimeArray)
                binding.strideBytes = decoration(in.back(), kArrayStride).value_or(0);
            else
                binding.strideBytes = sizeOf(type);
            binding.readonly = decoration(id, kNonWritable) || allMembers(type, kNonWritable);
            binding.writeonly = decoration(id, kNonReadable) || allMembers(type, kNonReadable);
        }
        result.bindings.push_back(binding);
    }

    std::string_view name_;
    std::span<const uint32_t> words_;
    ConstantsById constants_;
    Instruction sizeMode_;
    std::map<uint32_t, std::string> names_;
    std::map<uint32_t, Instruction> ids_;
    std::map<DecorationKey, uint32_t> decorations_;
    std::vector<uint32_t> variables_;
};

VkDescriptorType descriptorType(const Module& module, const ReflectedBinding& binding) {
    switch (binding.kind) {
        case BindingKind::storage:
            return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        case BindingKind::uniformTexel:
            return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
        case BindingKind::uniformBuffer:
            break;
    }
    throw renderError(
        fmt::format("{}: binding {} is a uniform buffer; the recorder binds storage and texel buffers", module.name, binding.binding));
}

std::string keyOf(const Module& module, const Specialization& constants) {
    std::string key = fmt::format("{} {} {}", module.name, module.sha256, fmt::ptr(module.words.data()));
    for (const auto& [name, value] : constants) key += fmt::format(" {}={}", name, value);
    return key;
}

// Given values by constant_id. Each constant of the module must be given; kNativeDivide and kNativeRoot default to the self-test's
// findings.
ConstantsById constantsById(const Module& module, const ModuleReader& reader, const SelfTest& selfTest, Specialization given) {
    ConstantsById byId;
    std::string has;
    for (const auto& [id, stated] : reader.specialized()) {
        const std::string name = stated.empty() ? unnamedConstant(id) : stated;
        const auto found = given.find(name);
        if (found != given.end())
            byId[id] = found->second, given.erase(found);
        else if (name == "kNativeDivide")
            byId[id] = selfTest.nativeDivideIsExact;
        else if (name == "kNativeRoot")
            byId[id] = selfTest.nativeRootIsExact;
        else
            throw renderError(fmt::format("{}: the constant {} is not given", module.name, name));
        has += (has.empty() ? "" : ", ") + name;
    }
    if (!given.empty())
        throw renderError(
            fmt::format("{}: no constant is called {} (the module has {})", module.name, given.begin()->first, has.empty() ? "none" : has));
    return byId;
}

}  // namespace

std::string unnamedBinding(uint32_t number) { return fmt::format("binding {}", number); }
std::string unnamedConstant(uint32_t id) { return fmt::format("constant {}", id); }

namespace {

// FNV-1a, a word at a time.
uint64_t hashOf(std::span<const uint32_t> words) {
    uint64_t hash = 14695981039346656037u;
    for (const uint32_t word : words) hash = (hash ^ word) * 1099511628211u;
    return hash;
}

// Drops the pipelines of words that the driver would not get any more.
void dropStale(DeviceImpl& device) {
    for (auto& [key, begun] : device.making) device.programs.emplace(key, begun.get());
    device.making.clear();
    std::erase_if(device.programs, [&](const auto& entry) {
        const Program& program = entry.second;
        if (hashOf(device.wordsOf(program.module, program.constants)) == program.wordsHash) return false;
        device.destroy(program);
        return true;
    });
}

}  // namespace

void plantDriver(Device& device, ModuleRewriter rewriter) {
    device.impl().rewriter = std::move(rewriter);
    dropStale(device.impl());
}

void plantModules(Device& device, std::map<std::string, std::vector<uint32_t>, std::less<>> words) {
    device.impl().planted = std::move(words);
    dropStale(device.impl());
}

bool hasSubgroupOperations(const Device& device) {
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
    vkGetPhysicalDeviceProperties2(device.impl().physical, &properties);
    constexpr VkSubgroupFeatureFlags kNeeded = VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT |
                                               VK_SUBGROUP_FEATURE_SHUFFLE_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
    return (subgroup.supportedOperations & kNeeded) == kNeeded && (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
}

Reflection reflect(const Module& module, const ConstantsById& constants) { return ModuleReader(module).reflection(constants); }

void DeviceImpl::destroy(const Program& program) const {
    vk.vkDestroyPipeline(handle, program.pipeline, nullptr);
    vk.vkDestroyPipelineLayout(handle, program.layout, nullptr);
    vk.vkDestroyDescriptorSetLayout(handle, program.setLayout, nullptr);
}

Program& DeviceImpl::program(const Module& module, const Specialization& constants) {
    const std::string key = keyOf(module, constants);
    if (const auto found = programs.find(key); found != programs.end()) return found->second;
    if (auto begun = making.extract(key)) return programs.emplace(key, begun.mapped().get()).first->second;
    return programs.emplace(key, make(module, constants)).first->second;
}

void DeviceImpl::prepare(const Module& module, const Specialization& constants) {
    std::string key = keyOf(module, constants);
    if (programs.contains(key) || making.contains(key)) return;
    making.emplace(std::move(key), std::async(std::launch::async, [this, &module, constants] { return make(module, constants); }));
}

ConstantsById DeviceImpl::constantsOf(const Module& module, const Specialization& constants) const {
    return constantsById(module, ModuleReader(module), selfTest, constants);
}

std::vector<uint32_t> DeviceImpl::wordsOf(const Module& module, const ConstantsById& constants) const {
    const auto plant = planted.find(module.name);
    std::vector<uint32_t> words =
        foldConstants(plant == planted.end() ? module : Module{module.name, plant->second, module.sha256}, constants);
    if (rewriter) rewriter(module.name, words);
    return words;
}

Program DeviceImpl::make(const Module& module, const Specialization& constants) const {
    ModuleReader reader(module);
    const ConstantsById all = constantsById(module, reader, selfTest, constants);
    Program program;
    program.reflection = reader.reflection(all);
    const Reflection& r = program.reflection;
    for (ReflectedBinding& binding : program.reflection.bindings)
        if (binding.name.empty()) binding.name = unnamedBinding(binding.binding);

    const uint64_t invocations = uint64_t(r.localSize[0]) * r.localSize[1] * r.localSize[2];
    if (invocations == 0 || invocations > limits.groupInvocations)
        throw renderError(
            fmt::format("{}: {} invocations a workgroup, the device allows 1 to {}", module.name, invocations, limits.groupInvocations));
    if (r.pushConstantBytes > limits.pushConstantBytes)
        throw renderError(fmt::format("{}: {} bytes of push constants, the device allows {}", module.name, r.pushConstantBytes,
                                      limits.pushConstantBytes));
    if (r.bindings.empty() || r.bindings[0].binding != 0 || r.bindings[0].kind != BindingKind::storage || r.bindings[0].strideBytes != 8 ||
        r.pushConstantBytes < 4)
        throw renderError(
            fmt::format("{}: binding 0 is not the Status buffer of shaders/shared/status.h, "
                        "or the push block does not begin with the status slot",
                        module.name));
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    uint32_t used[3] = {0, 0, uint32_t(r.bindings.size())};
    for (const ReflectedBinding& b : r.bindings) {
        if (b.binding != bindings.size()) throw renderError(fmt::format("{}: no binding has number {}", module.name, bindings.size()));
        bindings.push_back({b.binding, descriptorType(module, b), 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
        ++used[b.kind == BindingKind::storage ? 0 : 1];
    }
    for (int i = 0; i < 3; ++i)
        if (used[i] > stageBindings[i])
            throw renderError(fmt::format("{}: {} {}, the device allows {}", module.name, used[i],
                                          i == 0   ? "storage buffers"
                                          : i == 1 ? "texel buffers"
                                                   : "bindings",
                                          stageBindings[i]));

    // Frees a half-made pipeline when a step below throws.
    struct Discard {
        const DeviceImpl& device;
        Program& program;
        VkShaderModule shader = VK_NULL_HANDLE;
        bool done = false;
        ~Discard() {
            if (shader) device.vk.vkDestroyShaderModule(device.handle, shader, nullptr);
            if (!done) device.destroy(program);
        }
    };
    Discard discard{*this, program};

    const VkDescriptorSetLayoutCreateInfo setInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0,
                                                  uint32_t(bindings.size()), bindings.data()};
    VK_CHECK(vk.vkCreateDescriptorSetLayout(handle, &setInfo, nullptr, &program.setLayout));
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, (program.reflection.pushConstantBytes + 3u) & ~3u};
    const VkPipelineLayoutCreateInfo layoutInfo{
        VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, nullptr, 0, 1, &program.setLayout, 1, &range};
    VK_CHECK(vk.vkCreatePipelineLayout(handle, &layoutInfo, nullptr, &program.layout));
    const std::vector<uint32_t> words = wordsOf(module, all);
    program.module = module;
    program.constants = all;
    program.wordsHash = hashOf(words);
    const VkShaderModuleCreateInfo shaderInfo{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, nullptr, 0, words.size() * sizeof(uint32_t),
                                              words.data()};
    VK_CHECK(vk.vkCreateShaderModule(handle, &shaderInfo, nullptr, &discard.shader));

    std::vector<VkSpecializationMapEntry> entries;
    std::vector<uint32_t> values;
    for (const auto& [id, value] : all) {
        entries.push_back({id, uint32_t(values.size() * 4), 4});
        values.push_back(value);
    }
    const VkSpecializationInfo specialization{uint32_t(entries.size()), entries.data(), values.size() * 4, values.data()};
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_COMPUTE_BIT, discard.shader, "main",
                  entries.empty() ? nullptr : &specialization};
    info.layout = program.layout;
    const VkResult result = vk.vkCreateComputePipelines(handle, pipelineCache, 1, &info, nullptr, &program.pipeline);
    if (result != VK_SUCCESS)
        throw renderError(fmt::format("{}: the driver could not compile the module: {}", module.name, resultName(result)));
    discard.done = true;
    return program;
}

}  // namespace plumb
