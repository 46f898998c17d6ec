// SPDX-License-Identifier: MIT
#include "host/recorder.h"

#include "host/replay.h"
#include "host/vulkan.h"
#include "shared/status.h"

#include <fmt/format.h>
#include <cstdint>

#include <fmt/ranges.h>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>

namespace plumb {

namespace {

constexpr uint32_t kSlotsPerBuffer = 1024;
constexpr uint32_t kQueriesPerPool = 512;
constexpr uint32_t kSetsPerPool = 64, kDescriptorsPerSet = 8;
constexpr double kWitnessMs = 60000;  // watchdog of dispatches that a witness sees

const char* kindText(BindingKind kind) {
    switch (kind) {
        case BindingKind::storage:
            return "a storage buffer";
        case BindingKind::uniformTexel:
            return "a texel buffer";
        case BindingKind::uniformBuffer:
            return "a uniform buffer";
    }
    return "?";
}
const char* texelText(TexelType type) {
    switch (type) {
        case TexelType::floating:
            return "floats";
        case TexelType::unsignedInt:
            return "unsigned integers";
        case TexelType::signedInt:
            return "signed integers";
        case TexelType::none:
            break;
    }
    return "nothing";
}

struct ViewFormat {
    VkFormat format;
    TexelType type;
    uint32_t bytes;
};
ViewFormat viewFormat(View view) {
    switch (view) {
        case View::texelU32:
            return {VK_FORMAT_R32_UINT, TexelType::unsignedInt, 4};
        case View::texelU32x2:
            return {VK_FORMAT_R32G32_UINT, TexelType::unsignedInt, 8};
        case View::texelU32x4:
            return {VK_FORMAT_R32G32B32A32_UINT, TexelType::unsignedInt, 16};
        case View::texelF32:
            return {VK_FORMAT_R32_SFLOAT, TexelType::floating, 4};
        case View::texelF32x4:
            return {VK_FORMAT_R32G32B32A32_SFLOAT, TexelType::floating, 16};
        case View::storage:
            break;
    }
    return {VK_FORMAT_UNDEFINED, TexelType::none, 1};
}

// Byte range of a binding after all checks.
struct CheckedRange {
    uint64_t offset, range;
};

CheckedRange checkedRange(const DeviceLimits& limits, const Module& module, const ReflectedBinding& want, const Binding& bound) {
    const auto refuse = [&](const std::string& what) {
        return renderError(fmt::format("{}: binding {} {}", module.name, want.name, what));
    };
    if (!bound.buffer || !*bound.buffer) throw refuse("is given no buffer");
    const bool storage = bound.view == View::storage;
    const ViewFormat format = viewFormat(bound.view);
    const BindingKind kind = storage ? BindingKind::storage : BindingKind::uniformTexel;
    if (kind != want.kind) throw refuse(fmt::format("is {} in GLSL and {} in C++", kindText(want.kind), kindText(kind)));
    if (storage && bound.elementBytes != want.strideBytes)
        throw refuse(fmt::format("has elements of {} bytes in GLSL and {} in C++", want.strideBytes, bound.elementBytes));
    if (!storage && format.type != want.texel)
        throw refuse(fmt::format("reads {} in GLSL and {} in C++", texelText(want.texel), texelText(format.type)));
    const uint64_t bytes = bound.buffer->bytes();
    if (bound.offset >= bytes || bound.range > bytes - bound.offset)
        throw refuse(fmt::format("takes {} bytes from byte {} of buffer '{}', which has {}", bound.range, bound.offset,
                                 bound.buffer->impl().name, bytes));
    const uint32_t alignment = storage ? limits.storageOffsetAlignment : limits.texelOffsetAlignment;
    if (alignment != 0 && bound.offset % alignment != 0)
        throw refuse(fmt::format("begins at byte {} of buffer '{}'; the device wants a multiple of {}", bound.offset,
                                 bound.buffer->impl().name, alignment));
    uint64_t range = bound.range != 0 ? bound.range : bytes - bound.offset;
    if (storage) {
        if (range > limits.storageRangeBytes)
            throw refuse(fmt::format("takes {} bytes of buffer '{}', the device allows {}", range, bound.buffer->impl().name,
                                     limits.storageRangeBytes));
    } else {
        range -= range % format.bytes;
        if (range == 0) throw refuse(fmt::format("holds less than one texel of {} bytes", format.bytes));
        if (range / format.bytes > limits.texelElements)
            throw refuse(fmt::format("takes {} texels of buffer '{}', the device allows {}", range / format.bytes,
                                     bound.buffer->impl().name, limits.texelElements));
    }
    return {bound.offset, range};
}

std::vector<std::byte> bytesOf(const Binding& binding, uint64_t offset, uint64_t bytes) {
    const auto* first = static_cast<const std::byte*>(binding.buffer->data()) + offset;
    return {first, first + bytes};
}

// Describes a dispatch to a witness, but for what it leaves.
DispatchRecord recordOf(const DeviceImpl& device, const char* label, const Module& module, uint64_t items, std::span<const uint32_t> push,
                        std::span<const Binding* const> bindings, std::span<const CheckedRange> ranges, const Specialization& constants) {
    DispatchRecord record;
    record.label = label;
    record.module = module.name;
    record.constants = device.constantsOf(module, constants);
    record.words = device.wordsOf(module, record.constants);
    record.items = items;
    record.push.assign(push.begin(), push.end());
    for (size_t i = 0; i < bindings.size(); ++i)
        record.bindings.push_back({bindings[i]->name,
                                   bindings[i]->view,
                                   bindings[i]->elementBytes,
                                   bytesOf(*bindings[i], ranges[i].offset, ranges[i].range),
                                   {}});
    return record;
}

// Given bindings in the order of the module's own after its status. Each of the module's is given once, and nothing else.
std::vector<const Binding*> ordered(const Module& module, const Reflection& reflection, std::span<const Binding> given) {
    std::vector<const Binding*> inOrder(reflection.bindings.size() - 1);
    for (const Binding& binding : given) {
        size_t i = 0;
        while (i < inOrder.size() && reflection.bindings[i + 1].name != binding.name) ++i;
        if (i == inOrder.size()) throw renderError(fmt::format("{}: no binding is called {}", module.name, binding.name));
        if (inOrder[i]) throw renderError(fmt::format("{}: binding {} is given twice", module.name, binding.name));
        inOrder[i] = &binding;
    }
    for (size_t i = 0; i < inOrder.size(); ++i)
        if (!inOrder[i]) throw renderError(fmt::format("{}: binding {} is not given", module.name, reflection.bindings[i + 1].name));
    return inOrder;
}

}  // namespace

struct RecorderImpl {
    struct Command {
        std::string label;
        bool counted = false;  // true for a dispatch, which has a status slot
        uint32_t slot = 0, groups = 0;
    };

    DeviceImpl& device;
    VkCommandPool commandPool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    std::vector<VkDescriptorPool> descriptorPools;
    size_t descriptorPool = 0;  // index of the pool in use
    std::vector<VkQueryPool> queryPools;
    std::vector<BufferImpl> statusBuffers;  // kSlotsPerBuffer slots each
    std::vector<Command> recorded;
    uint32_t slots = 0;
    bool recording = false;
    double apartMs = 0;          // watchdog of commands that run one by one; 0: they run together
    uint32_t everyCommands = 0;  // 0: no limit
    double everyMs = 0;
    std::function<void()> between;
    std::vector<PassTime> times;
    std::optional<std::vector<std::string>> allowed;  // labels that may be used; none: all
    std::map<std::string, std::string> skipped;       // reason by label

    explicit RecorderImpl(DeviceImpl& d);
    gpu::StatusSlot& status(uint32_t slot) const;
    ~RecorderImpl();
    void checkLabel(const char* label) const;
    void begin();
    void beginCommand();
    void endCommand(Command command);
    VkDescriptorSet allocateSet(VkDescriptorSetLayout layout, uint32_t descriptors);
    void submitAndWait(double watchdogMs);
    void empty();
    void check() const;
    void addTimes(double hostMs);
    void addTime(const std::string& pass, double ms, uint32_t dispatches);
    void destroy();
};

RecorderImpl::RecorderImpl(DeviceImpl& d) : device(d) {
    try {
        const VkCommandPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                               device.queueFamily};
        VK_CHECK(device.vk.vkCreateCommandPool(device.handle, &poolInfo, nullptr, &commandPool));
        const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, commandPool,
                                               VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        VK_CHECK(device.vk.vkAllocateCommandBuffers(device.handle, &info, &commands));
        const VkFenceCreateInfo fenceInfo{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        VK_CHECK(device.vk.vkCreateFence(device.handle, &fenceInfo, nullptr, &fence));
    } catch (...) {
        destroy();
        throw;
    }
}

RecorderImpl::~RecorderImpl() {
    if (device.hung && device.vk.vkWaitForFences(device.handle, 1, &fence, VK_TRUE, uint64_t(kGraceMs * 1e6)) == VK_SUCCESS)
        device.hung = false;
    if (!device.hung) destroy();
}

void RecorderImpl::destroy() {
    for (const VkQueryPool pool : queryPools) device.vk.vkDestroyQueryPool(device.handle, pool, nullptr);
    for (const VkDescriptorPool pool : descriptorPools) device.vk.vkDestroyDescriptorPool(device.handle, pool, nullptr);
    device.vk.vkDestroyFence(device.handle, fence, nullptr);
    device.vk.vkDestroyCommandPool(device.handle, commandPool, nullptr);
}

gpu::StatusSlot& RecorderImpl::status(uint32_t slot) const {
    return static_cast<gpu::StatusSlot*>(statusBuffers[slot / kSlotsPerBuffer].block->mapped)[slot % kSlotsPerBuffer];
}

void RecorderImpl::checkLabel(const char* label) const {
    if (allowed && std::find(allowed->begin(), allowed->end(), label) == allowed->end())
        throw renderError(fmt::format("{}: no step of the plan has this name (its steps here are {})", label, fmt::join(*allowed, ", ")));
}

void RecorderImpl::begin() {
    if (device.hung) throw renderError("the device may still be busy: the end of its last work was not seen");
    if (recording) return;
    const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
                                        nullptr};
    VK_CHECK(device.vk.vkBeginCommandBuffer(commands, &info));
    recording = true;
}

// Begins a command: a full barrier to earlier commands, and the first time stamp.
void RecorderImpl::beginCommand() {
    if (!recorded.empty()) {
        const VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                                      VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                                          VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT};
        device.vk.vkCmdPipelineBarrier(
            commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
            VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT, 0, 1, &barrier, 0,
            nullptr, 0, nullptr);
    }
    if (device.limits.timestampPeriodNs == 0) return;
    const uint32_t query = uint32_t(recorded.size()) * 2;
    if (query % kQueriesPerPool == 0) {
        if (query / kQueriesPerPool == queryPools.size()) {
            const VkQueryPoolCreateInfo info{
                VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, VK_QUERY_TYPE_TIMESTAMP, kQueriesPerPool, 0};
            VkQueryPool pool;
            VK_CHECK(device.vk.vkCreateQueryPool(device.handle, &info, nullptr, &pool));
            queryPools.push_back(pool);
        }
        device.vk.vkCmdResetQueryPool(commands, queryPools[query / kQueriesPerPool], 0, kQueriesPerPool);
    }
    // Time stamp at the bottom of the pipe: it waits for everything before, so passes do not overlap in the report.
    device.vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queryPools[query / kQueriesPerPool],
                                  query % kQueriesPerPool);
}

void RecorderImpl::endCommand(Command command) {
    if (device.limits.timestampPeriodNs != 0) {
        const uint32_t query = uint32_t(recorded.size()) * 2 + 1;
        device.vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queryPools[query / kQueriesPerPool],
                                      query % kQueriesPerPool);
    }
    recorded.push_back(std::move(command));
}

VkDescriptorSet RecorderImpl::allocateSet(VkDescriptorSetLayout layout, uint32_t descriptors) {
    for (;;) {
        const bool fresh = descriptorPool == descriptorPools.size();
        if (fresh) {
            const uint32_t each = kSetsPerPool * std::max(kDescriptorsPerSet, descriptors);
            const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, each},
                                                  {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, each}};
            const VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, kSetsPerPool, 2, sizes};
            VkDescriptorPool pool;
            VK_CHECK(device.vk.vkCreateDescriptorPool(device.handle, &info, nullptr, &pool));
            descriptorPools.push_back(pool);
        }
        const VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, descriptorPools[descriptorPool], 1,
                                               &layout};
        VkDescriptorSet set;
        const VkResult result = device.vk.vkAllocateDescriptorSets(device.handle, &info, &set);
        if (result == VK_SUCCESS) return set;
        if (fresh || (result != VK_ERROR_OUT_OF_POOL_MEMORY && result != VK_ERROR_FRAGMENTED_POOL))
            throw renderError(fmt::format("{} from vkAllocateDescriptorSets", resultName(result)));
        ++descriptorPool;
    }
}

void RecorderImpl::empty() {
    recorded.clear();
    slots = 0;
    descriptorPool = 0;
    recording = false;
    VK_CHECK(device.vk.vkResetCommandPool(device.handle, commandPool, 0));
    for (const VkDescriptorPool pool : descriptorPools) VK_CHECK(device.vk.vkResetDescriptorPool(device.handle, pool, 0));
    VK_CHECK(device.vk.vkResetFences(device.handle, 1, &fence));
}

void RecorderImpl::check() const {
    for (const Command& command : recorded) {
        if (!command.counted) continue;
        const gpu::StatusSlot& slot = status(command.slot);
        if (slot.fault & gpu::kFaultLoop)
            throw LoopBudgetError(fmt::format("{}: a loop stopped before its end (loop budget of the device)", command.label));
        if (slot.fault & gpu::kFaultRange)
            throw renderError(fmt::format("{}: a value left the range that its contract states", command.label));
        if (slot.fault != 0) throw renderError(fmt::format("{}: fault {:#x}", command.label, slot.fault));
        if (slot.finished < command.groups)
            throw renderError(
                fmt::format("{}: {} of {} workgroups did not finish", command.label, command.groups - slot.finished, command.groups));
        if (slot.finished > command.groups)
            throw renderError(fmt::format("{}: {} workgroups finished, {} were asked for", command.label, slot.finished, command.groups));
    }
}

void RecorderImpl::addTime(const std::string& pass, double ms, uint32_t dispatches) {
    auto it = std::find_if(times.begin(), times.end(), [&](const PassTime& t) { return t.pass == pass; });
    if (it == times.end()) it = times.insert(times.end(), PassTime{pass, 0, 0});
    it->ms += ms;
    it->dispatches += dispatches;
}

void RecorderImpl::addTimes(double hostMs) {
    if (device.limits.timestampPeriodNs == 0 || apartMs > 0) {
        for (const Command& command : recorded) addTime(command.label, 0, 1);
        addTime(recorded.size() == 1 ? recorded[0].label : "whole submission (host time)", hostMs, 0);
        return;
    }
    std::vector<uint64_t> stamps(kQueriesPerPool);
    const uint64_t mask = device.timestampBits >= 64 ? ~uint64_t(0) : (uint64_t(1) << device.timestampBits) - 1;
    for (size_t first = 0; first < recorded.size(); first += kQueriesPerPool / 2) {
        const size_t count = std::min<size_t>(recorded.size() - first, kQueriesPerPool / 2);
        VK_CHECK(device.vk.vkGetQueryPoolResults(device.handle, queryPools[first * 2 / kQueriesPerPool], 0, uint32_t(count * 2), count * 16,
                                                 stamps.data(), 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
        for (size_t i = 0; i < count; ++i)
            addTime(recorded[first + i].label, double((stamps[2 * i + 1] - stamps[2 * i]) & mask) * device.limits.timestampPeriodNs * 1e-6,
                    1);
    }
}

const std::set<std::string, std::less<>>& modulesRun(const Device& device) { return device.impl().modulesRun; }

Recorder::Recorder(Device& device) : impl_(std::make_unique<RecorderImpl>(device.impl())) {}
Recorder::~Recorder() = default;
Recorder::Recorder(Recorder&&) noexcept = default;

void Recorder::prepare(const Module& module, const Specialization& constants) { impl_->device.prepare(module, constants); }

void Recorder::record(const char* label, const Module& module, uint64_t items, void* push, size_t pushBytes, std::span<const Binding> given,
                      const Specialization& constants) {
    RecorderImpl& r = *impl_;
    r.checkLabel(label);
    DeviceImpl& device = r.device;
    if (device.witness) run(kWitnessMs);  // the input is what earlier commands leave
    Program& program = device.program(module, constants);
    const Reflection& reflection = program.reflection;
    if (pushBytes != reflection.pushConstantBytes)
        throw renderError(
            fmt::format("{}: the push block has {} bytes in GLSL and {} in C++", module.name, reflection.pushConstantBytes, pushBytes));
    const std::vector<const Binding*> bindings = ordered(module, reflection, given);
    std::vector<CheckedRange> ranges;
    for (size_t i = 0; i < bindings.size(); ++i)
        ranges.push_back(checkedRange(device.limits, module, reflection.bindings[i + 1], *bindings[i]));
    if (items == 0) return skip(label, "nothing was left for it");
    const uint64_t groups = (items - 1) / reflection.localSize[0] + 1;
    const uint64_t rows = (groups - 1) / std::max<uint64_t>(device.limits.groupCount[0], 1) + 1;
    const uint64_t columns = (groups - 1) / rows + 1;
    // Items are numbered in 32 bits, and the spare groups of the last row must not wrap.
    if (items > UINT32_MAX || rows * columns * reflection.localSize[0] > UINT32_MAX || columns > device.limits.groupCount[0] ||
        rows > device.limits.groupCount[1])
        throw renderError(fmt::format("{}: {} items are {} workgroups, the device allows {} x {}", module.name, items, groups,
                                      device.limits.groupCount[0], device.limits.groupCount[1]));

    if (r.slots / kSlotsPerBuffer == r.statusBuffers.size())
        r.statusBuffers.emplace_back(device.memory, kSlotsPerBuffer * sizeof(gpu::StatusSlot), "status");
    const BufferImpl& status = r.statusBuffers[r.slots / kSlotsPerBuffer];
    const uint32_t slot = r.slots % kSlotsPerBuffer;
    r.status(r.slots) = {};
    std::memcpy(push, &slot, sizeof slot);
    std::optional<DispatchRecord> witnessed;
    if (device.witness)
        witnessed =
            recordOf(device, label, module, items, {static_cast<const uint32_t*>(push), pushBytes / 4}, bindings, ranges, constants);

    device.modulesRun.emplace(module.name);
    r.begin();
    const VkDescriptorSet set = r.allocateSet(program.setLayout, uint32_t(reflection.bindings.size()));
    std::vector<VkDescriptorBufferInfo> buffers(reflection.bindings.size());
    std::vector<VkBufferView> views(reflection.bindings.size());
    std::vector<VkWriteDescriptorSet> writes;
    buffers[0] = {status.block->buffer, 0, status.bytes};
    for (uint32_t b = 0; b < reflection.bindings.size(); ++b) {
        VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, b, 0, 1};
        if (reflection.bindings[b].kind == BindingKind::storage) {
            if (b > 0) buffers[b] = {bindings[b - 1]->buffer->impl().block->buffer, ranges[b - 1].offset, ranges[b - 1].range};
            write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            write.pBufferInfo = &buffers[b];
        } else {
            const Binding& bound = *bindings[b - 1];
            views[b] =
                device.memory->view(*bound.buffer->impl().block, viewFormat(bound.view).format, ranges[b - 1].offset, ranges[b - 1].range);
            write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
            write.pTexelBufferView = &views[b];
        }
        writes.push_back(write);
    }
    device.vk.vkUpdateDescriptorSets(device.handle, uint32_t(writes.size()), writes.data(), 0, nullptr);

    r.beginCommand();
    device.vk.vkCmdBindPipeline(r.commands, VK_PIPELINE_BIND_POINT_COMPUTE, program.pipeline);
    device.vk.vkCmdBindDescriptorSets(r.commands, VK_PIPELINE_BIND_POINT_COMPUTE, program.layout, 0, 1, &set, 0, nullptr);
    device.vk.vkCmdPushConstants(r.commands, program.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, uint32_t(pushBytes), push);
    device.vk.vkCmdDispatch(r.commands, uint32_t(columns), uint32_t(rows), 1);
    r.endCommand({label, true, r.slots, uint32_t(columns * rows)});
    ++r.slots;
    if (!witnessed) return runWhenDue();
    // The dispatch by itself, and what it leaves, also where it fails.
    const auto tell = [&] {
        for (size_t i = 0; i < bindings.size(); ++i)
            witnessed->bindings[i].after = bytesOf(*bindings[i], ranges[i].offset, ranges[i].range);
        device.witness(*witnessed);
    };
    try {
        run(kWitnessMs);
    } catch (const Error& error) {
        witnessed->failure = error.what();
        tell();
        throw;
    }
    tell();
}

void Recorder::fill(const char* label, const RawBuffer& buffer, uint32_t word, uint64_t offset, uint64_t bytes) {
    impl_->checkLabel(label);
    if (!buffer) throw renderError(fmt::format("{}: no buffer to fill", label));
    const uint64_t all = buffer.bytes() & ~uint64_t(3);
    if (offset % 4 != 0 || bytes % 4 != 0 || offset > all || bytes > all - offset)
        throw renderError(fmt::format("{}: {} bytes from byte {} of buffer '{}', which has {}, cannot be filled by words", label, bytes,
                                      offset, buffer.impl().name, buffer.bytes()));
    const uint64_t range = bytes != 0 ? bytes : all - offset;
    if (range == 0) return;
    RecorderImpl& r = *impl_;
    r.begin();
    r.beginCommand();
    r.device.vk.vkCmdFillBuffer(r.commands, buffer.impl().block->buffer, offset, range, word);
    r.endCommand({label, false, 0, 0});
    runWhenDue();
}

void RecorderImpl::submitAndWait(double watchdogMs) {
    const VkMemoryBarrier toHost{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                                 VK_ACCESS_HOST_READ_BIT | VK_ACCESS_HOST_WRITE_BIT};
    device.vk.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                                   VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &toHost, 0, nullptr, 0, nullptr);
    VK_CHECK(device.vk.vkEndCommandBuffer(commands));
    const VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO, nullptr, 0, nullptr, nullptr, 1, &commands, 0, nullptr};
    VK_CHECK(device.vk.vkQueueSubmit(device.queue, 1, &submit, fence));
    const double timeoutNs = std::clamp(watchdogMs * 1e6, 0.0, 1e18);
    const VkResult waited = device.vk.vkWaitForFences(device.handle, 1, &fence, VK_TRUE, uint64_t(timeoutNs));
    if (waited == VK_SUCCESS) return;
    const std::string what = recorded.front().label + (recorded.size() > 1 ? fmt::format(" and {} more", recorded.size() - 1) : "");
    device.hung = true;  // whatever the wait failed with, the work may run on; the destructor waits once more
    if (waited == VK_TIMEOUT) throw renderError(fmt::format("{}: the device did not finish within {:.0f} ms (watchdog)", what, watchdogMs));
    throw renderError(fmt::format("{}: {} while waiting for the device", what, resultName(waited)));
}

void Recorder::run(double watchdogMs) {
    RecorderImpl& r = *impl_;
    if (r.recorded.empty()) return;
    const auto start = std::chrono::steady_clock::now();
    try {
        r.submitAndWait(watchdogMs);
        r.check();
        r.addTimes(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    } catch (...) {
        if (!r.device.hung) r.empty();
        throw;
    }
    r.empty();
}

void Recorder::runWhenDue() {
    RecorderImpl& r = *impl_;
    if (r.apartMs > 0) return run(r.apartMs);
    if (r.everyCommands == 0 || r.recorded.size() < r.everyCommands) return;
    run(r.everyMs);
    if (r.between) r.between();
}

void Recorder::runEvery(uint32_t commands, double watchdogMs, std::function<void()> between) {
    impl_->everyCommands = commands;
    impl_->everyMs = watchdogMs;
    impl_->between = std::move(between);
}

void Recorder::timeApart(double watchdogMs) { impl_->apartMs = watchdogMs; }

void Recorder::allow(std::vector<std::string> labels) { impl_->allowed = std::move(labels); }

void Recorder::skip(const char* label, const char* why) { impl_->skipped[label] = why; }

std::map<std::string, std::string> Recorder::takeSkipped() { return std::exchange(impl_->skipped, {}); }

std::vector<PassTime> Recorder::takeTimes() { return std::exchange(impl_->times, {}); }

}  // namespace plumb
