// SPDX-License-Identifier: MIT
// Loads Vulkan by itself (no volk): two devices in one process must not share volk's table of device functions.
#include "tests/oracle/fixed_function.h"

#define VK_NO_PROTOTYPES
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>

#include <oracle_spirv/fixed_function_frag.h>
#include <oracle_spirv/fixed_function_vert.h>

namespace plumb::oracle {
namespace {

void check(VkResult result, const char* what) {
    if (result != VK_SUCCESS) throw std::runtime_error(std::string("fixed-function witness: ") + what + " gives " + std::to_string(result));
}

// clang-format off
#define INSTANCE_FUNCTIONS(f) \
    f(DestroyInstance) f(EnumeratePhysicalDevices) f(GetPhysicalDeviceProperties2) f(GetPhysicalDeviceQueueFamilyProperties) \
    f(GetPhysicalDeviceMemoryProperties) f(CreateDevice) f(GetDeviceProcAddr)
#define DEVICE_FUNCTIONS(f) \
    f(DestroyDevice) f(GetDeviceQueue) f(CreateBuffer) f(DestroyBuffer) f(GetBufferMemoryRequirements) f(AllocateMemory) f(FreeMemory) \
    f(BindBufferMemory) f(BindImageMemory) f(MapMemory) f(CreateImage) f(DestroyImage) f(GetImageMemoryRequirements) f(CreateImageView) \
    f(DestroyImageView) f(CreateRenderPass) f(DestroyRenderPass) f(CreateFramebuffer) f(DestroyFramebuffer) f(CreateShaderModule) \
    f(DestroyShaderModule) f(CreatePipelineLayout) f(DestroyPipelineLayout) f(CreateGraphicsPipelines) f(DestroyPipeline) \
    f(CreateCommandPool) f(DestroyCommandPool) f(AllocateCommandBuffers) f(BeginCommandBuffer) f(EndCommandBuffer) f(CmdBeginRenderPass) \
    f(CmdEndRenderPass) f(CmdBindPipeline) f(CmdSetViewport) f(CmdSetScissor) f(CmdBindVertexBuffers) f(CmdDraw) f(CmdCopyImageToBuffer) \
    f(CmdPipelineBarrier) f(QueueSubmit) f(QueueWaitIdle)
// clang-format on

struct Vertex {
    ClipPosition position;
    uint32_t id;
};

}  // namespace

struct FixedFunction::Impl {
    void* loader = nullptr;
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
#define DECLARE(name) PFN_vk##name vk##name = nullptr;
    INSTANCE_FUNCTIONS(DECLARE)
    DEVICE_FUNCTIONS(DECLARE)
#undef DECLARE
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;
    VkPhysicalDeviceMemoryProperties memoryTypes{};
    VkRenderPass renderPass = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;

    struct Block {
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        void* data = nullptr;
        VkDeviceSize bytes = 0;
    };
    struct Target {
        VkImage image = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkImageView view = VK_NULL_HANDLE;
    };
    Block vertices, idsBack, depthBack;
    Target idTarget, depthTarget;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    uint32_t width = 0, height = 0;

    uint32_t memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
        for (uint32_t i = 0; i < memoryTypes.memoryTypeCount; ++i)
            if ((allowed >> i & 1u) && (memoryTypes.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
        throw std::runtime_error("fixed-function witness: no memory type fits");
    }

    void release(Block& block) {
        if (block.buffer) vkDestroyBuffer(device, block.buffer, nullptr);
        if (block.memory) vkFreeMemory(device, block.memory, nullptr);
        block = {};
    }
    void reserve(Block& block, VkDeviceSize bytes, VkBufferUsageFlags usage) {
        if (block.bytes >= bytes) return;
        release(block);
        VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        info.size = bytes;
        info.usage = usage;
        check(vkCreateBuffer(device, &info, nullptr, &block.buffer), "vkCreateBuffer");
        VkMemoryRequirements need;
        vkGetBufferMemoryRequirements(device, block.buffer, &need);
        VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocate.allocationSize = need.size;
        allocate.memoryTypeIndex =
            memoryType(need.memoryTypeBits, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
        check(vkAllocateMemory(device, &allocate, nullptr, &block.memory), "vkAllocateMemory");
        check(vkBindBufferMemory(device, block.buffer, block.memory, 0), "vkBindBufferMemory");
        check(vkMapMemory(device, block.memory, 0, VK_WHOLE_SIZE, 0, &block.data), "vkMapMemory");
        block.bytes = bytes;
    }

    void release(Target& target) {
        if (target.view) vkDestroyImageView(device, target.view, nullptr);
        if (target.image) vkDestroyImage(device, target.image, nullptr);
        if (target.memory) vkFreeMemory(device, target.memory, nullptr);
        target = {};
    }
    void create(Target& target, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect) {
        VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        info.imageType = VK_IMAGE_TYPE_2D;
        info.format = format;
        info.extent = {width, height, 1};
        info.mipLevels = info.arrayLayers = 1;
        info.samples = VK_SAMPLE_COUNT_1_BIT;
        info.usage = usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
        check(vkCreateImage(device, &info, nullptr, &target.image), "vkCreateImage");
        VkMemoryRequirements need;
        vkGetImageMemoryRequirements(device, target.image, &need);
        VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocate.allocationSize = need.size;
        allocate.memoryTypeIndex = memoryType(need.memoryTypeBits, 0);
        check(vkAllocateMemory(device, &allocate, nullptr, &target.memory), "vkAllocateMemory");
        check(vkBindImageMemory(device, target.image, target.memory, 0), "vkBindImageMemory");
        VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
        view.image = target.image;
        view.viewType = VK_IMAGE_VIEW_TYPE_2D;
        view.format = format;
        view.subresourceRange = {aspect, 0, 1, 0, 1};
        check(vkCreateImageView(device, &view, nullptr, &target.view), "vkCreateImageView");
    }

    void loadInstance() {
        loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
        if (!loader) throw std::runtime_error("fixed-function witness: there is no libvulkan.so.1");
        getInstanceProcAddr = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(loader, "vkGetInstanceProcAddr"));
        const auto createInstance = reinterpret_cast<PFN_vkCreateInstance>(getInstanceProcAddr(nullptr, "vkCreateInstance"));
        VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
        application.apiVersion = VK_API_VERSION_1_2;
        VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        info.pApplicationInfo = &application;
        check(createInstance(&info, nullptr, &instance), "vkCreateInstance");
#define LOAD(name) vk##name = reinterpret_cast<PFN_vk##name>(getInstanceProcAddr(instance, "vk" #name));
        INSTANCE_FUNCTIONS(LOAD)
#undef LOAD
    }

    void openLavapipe() {
        uint32_t count = 0;
        check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
        std::vector<VkPhysicalDevice> all(count);
        check(vkEnumeratePhysicalDevices(instance, &count, all.data()), "vkEnumeratePhysicalDevices");
        for (VkPhysicalDevice candidate : all) {
            VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
            VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
            vkGetPhysicalDeviceProperties2(candidate, &properties);
            if (driver.driverID != VK_DRIVER_ID_MESA_LLVMPIPE) continue;
            if (properties.properties.limits.subPixelPrecisionBits != 8)
                throw std::runtime_error("fixed-function witness: lavapipe with another number of sub-pixel bits than 8");
            physical = candidate;
        }
        if (!physical) throw std::runtime_error("fixed-function witness: there is no lavapipe among the devices");
        vkGetPhysicalDeviceMemoryProperties(physical, &memoryTypes);
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
        std::vector<VkQueueFamilyProperties> families(count);
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
        while (family < count && !(families[family].queueFlags & VK_QUEUE_GRAPHICS_BIT)) ++family;
        if (family == count) throw std::runtime_error("fixed-function witness: no graphics queue");
        const float priority = 1.0f;
        VkDeviceQueueCreateInfo queueInfo{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
        queueInfo.queueFamilyIndex = family;
        queueInfo.queueCount = 1;
        queueInfo.pQueuePriorities = &priority;
        VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
        info.queueCreateInfoCount = 1;
        info.pQueueCreateInfos = &queueInfo;
        check(vkCreateDevice(physical, &info, nullptr, &device), "vkCreateDevice");
#define LOAD(name) vk##name = reinterpret_cast<PFN_vk##name>(vkGetDeviceProcAddr(device, "vk" #name));
        DEVICE_FUNCTIONS(LOAD)
#undef LOAD
        vkGetDeviceQueue(device, family, 0, &queue);
        VkCommandPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        poolInfo.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        poolInfo.queueFamilyIndex = family;
        check(vkCreateCommandPool(device, &poolInfo, nullptr, &pool), "vkCreateCommandPool");
        VkCommandBufferAllocateInfo one{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        one.commandPool = pool;
        one.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
        one.commandBufferCount = 1;
        check(vkAllocateCommandBuffers(device, &one, &commands), "vkAllocateCommandBuffers");
    }

    void createRenderPass() {
        std::array<VkAttachmentDescription, 2> attachments{};
        for (VkAttachmentDescription& a : attachments) {
            a.samples = VK_SAMPLE_COUNT_1_BIT;
            a.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
            a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
            a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
            a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
            a.finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        }
        attachments[0].format = VK_FORMAT_R32_UINT;
        attachments[1].format = VK_FORMAT_D32_SFLOAT;
        const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
        VkSubpassDescription subpass{};
        subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &colour;
        subpass.pDepthStencilAttachment = &depth;
        VkSubpassDependency toCopy{};
        toCopy.dstSubpass = VK_SUBPASS_EXTERNAL;
        toCopy.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
        toCopy.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
        toCopy.dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
        toCopy.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
        info.attachmentCount = attachments.size();
        info.pAttachments = attachments.data();
        info.subpassCount = 1;
        info.pSubpasses = &subpass;
        info.dependencyCount = 1;
        info.pDependencies = &toCopy;
        check(vkCreateRenderPass(device, &info, nullptr, &renderPass), "vkCreateRenderPass");
    }

    VkShaderModule shader(std::span<const uint32_t> words) {
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = words.size_bytes();
        info.pCode = words.data();
        VkShaderModule made = VK_NULL_HANDLE;
        check(vkCreateShaderModule(device, &info, nullptr, &made), "vkCreateShaderModule");
        return made;
    }

    void createPipeline() {
        const VkPipelineLayoutCreateInfo layoutInfo{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        check(vkCreatePipelineLayout(device, &layoutInfo, nullptr, &layout), "vkCreatePipelineLayout");
        std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
        for (auto& stage : stages) {
            stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
            stage.pName = "main";
        }
        stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
        stages[0].module = shader(kFixedFunctionVert);
        stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
        stages[1].module = shader(kFixedFunctionFrag);
        const VkVertexInputBindingDescription binding{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX};
        const std::array<VkVertexInputAttributeDescription, 2> attributes{
            VkVertexInputAttributeDescription{0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, position)},
            VkVertexInputAttributeDescription{1, 0, VK_FORMAT_R32_UINT, offsetof(Vertex, id)}};
        VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
        input.vertexBindingDescriptionCount = 1;
        input.pVertexBindingDescriptions = &binding;
        input.vertexAttributeDescriptionCount = attributes.size();
        input.pVertexAttributeDescriptions = attributes.data();
        VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
        assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
        viewport.viewportCount = viewport.scissorCount = 1;
        VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
        raster.polygonMode = VK_POLYGON_MODE_FILL;
        raster.cullMode = VK_CULL_MODE_NONE;
        raster.lineWidth = 1.0f;
        VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
        samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
        VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
        depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
        depth.depthCompareOp = VK_COMPARE_OP_GREATER;
        VkPipelineColorBlendAttachmentState write{};
        write.colorWriteMask = VK_COLOR_COMPONENT_R_BIT;
        VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
        blend.attachmentCount = 1;
        blend.pAttachments = &write;
        const std::array<VkDynamicState, 2> dynamicStates{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
        VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
        dynamic.dynamicStateCount = dynamicStates.size();
        dynamic.pDynamicStates = dynamicStates.data();
        VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
        info.stageCount = stages.size();
        info.pStages = stages.data();
        info.pVertexInputState = &input;
        info.pInputAssemblyState = &assembly;
        info.pViewportState = &viewport;
        info.pRasterizationState = &raster;
        info.pMultisampleState = &samples;
        info.pDepthStencilState = &depth;
        info.pColorBlendState = &blend;
        info.pDynamicState = &dynamic;
        info.layout = layout;
        info.renderPass = renderPass;
        const VkResult made = vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
        for (const auto& stage : stages) vkDestroyShaderModule(device, stage.module, nullptr);
        check(made, "vkCreateGraphicsPipelines");
    }

    void resize(uint32_t newWidth, uint32_t newHeight) {
        if (newWidth == width && newHeight == height) return;
        releaseTargets();
        width = newWidth;
        height = newHeight;
        create(idTarget, VK_FORMAT_R32_UINT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
        create(depthTarget, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT);
        const std::array<VkImageView, 2> views{idTarget.view, depthTarget.view};
        VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
        info.renderPass = renderPass;
        info.attachmentCount = views.size();
        info.pAttachments = views.data();
        info.width = width;
        info.height = height;
        info.layers = 1;
        check(vkCreateFramebuffer(device, &info, nullptr, &framebuffer), "vkCreateFramebuffer");
    }

    void releaseTargets() {
        if (framebuffer) vkDestroyFramebuffer(device, framebuffer, nullptr);
        framebuffer = VK_NULL_HANDLE;
        release(idTarget);
        release(depthTarget);
        width = height = 0;
    }

    Impl() {
        try {
            loadInstance();
            openLavapipe();
            createRenderPass();
            createPipeline();
        } catch (...) {
            releaseAll();
            throw;
        }
    }
    ~Impl() { releaseAll(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void releaseAll() {
        if (device && vkDestroyDevice) {
            releaseTargets();
            for (Block* block : {&vertices, &idsBack, &depthBack}) release(*block);
            if (pipeline) vkDestroyPipeline(device, pipeline, nullptr);
            if (layout) vkDestroyPipelineLayout(device, layout, nullptr);
            if (renderPass) vkDestroyRenderPass(device, renderPass, nullptr);
            if (pool) vkDestroyCommandPool(device, pool, nullptr);
            vkDestroyDevice(device, nullptr);
        }
        if (instance && vkDestroyInstance) vkDestroyInstance(instance, nullptr);
        if (loader) dlclose(loader);
    }

    void copyBack(const Target& target, VkImageAspectFlags aspect, const Block& to) {
        VkBufferImageCopy region{};
        region.imageSubresource = {aspect, 0, 0, 1};
        region.imageExtent = {width, height, 1};
        vkCmdCopyImageToBuffer(commands, target.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.buffer, 1, &region);
    }
};

FixedFunction::FixedFunction() : impl_(std::make_unique<Impl>()) {}
FixedFunction::~FixedFunction() = default;

DrawnFrame FixedFunction::draw(uint32_t width, uint32_t height, std::span<const ClipPosition> vertices, std::span<const uint32_t> ids) {
    if (vertices.size() != 3 * ids.size()) throw std::runtime_error("fixed-function witness: three vertices a triangle");
    if (float(std::max(width, height)) * kGuard > 16384.0f) throw std::runtime_error("fixed-function witness: the frame is too large");
    Impl& v = *impl_;
    v.resize(width, height);
    const size_t pixels = size_t(width) * height;
    v.reserve(v.vertices, vertices.size() * sizeof(Vertex) + 1, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    v.reserve(v.idsBack, pixels * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    v.reserve(v.depthBack, pixels * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    auto* upload = static_cast<Vertex*>(v.vertices.data);
    for (size_t i = 0; i < vertices.size(); ++i) {
        const ClipPosition& p = vertices[i];
        upload[i] = {{p.x / kGuard, p.y / kGuard, p.z, p.w}, ids[i / 3]};
    }

    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(v.vkBeginCommandBuffer(v.commands, &begin), "vkBeginCommandBuffer");
    std::array<VkClearValue, 2> clear{};
    clear[0].color.uint32[0] = kNothingDrawn;
    clear[1].depthStencil.depth = 0.0f;
    VkRenderPassBeginInfo pass{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    pass.renderPass = v.renderPass;
    pass.framebuffer = v.framebuffer;
    pass.renderArea.extent = {width, height};
    pass.clearValueCount = clear.size();
    pass.pClearValues = clear.data();
    v.vkCmdBeginRenderPass(v.commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
    const float beside = (1.0f - kGuard) / 2.0f;
    const VkViewport viewport{beside * float(width), beside * float(height), kGuard * float(width), kGuard * float(height), 0, 1};
    const VkRect2D scissor{{0, 0}, {width, height}};
    const VkDeviceSize offset = 0;
    v.vkCmdBindPipeline(v.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, v.pipeline);
    v.vkCmdSetViewport(v.commands, 0, 1, &viewport);
    v.vkCmdSetScissor(v.commands, 0, 1, &scissor);
    v.vkCmdBindVertexBuffers(v.commands, 0, 1, &v.vertices.buffer, &offset);
    if (!vertices.empty()) v.vkCmdDraw(v.commands, uint32_t(vertices.size()), 1, 0, 0);
    v.vkCmdEndRenderPass(v.commands);
    v.copyBack(v.idTarget, VK_IMAGE_ASPECT_COLOR_BIT, v.idsBack);
    v.copyBack(v.depthTarget, VK_IMAGE_ASPECT_DEPTH_BIT, v.depthBack);
    VkMemoryBarrier toHost{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    toHost.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    toHost.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    v.vkCmdPipelineBarrier(v.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &toHost, 0, nullptr, 0, nullptr);
    check(v.vkEndCommandBuffer(v.commands), "vkEndCommandBuffer");
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &v.commands;
    check(v.vkQueueSubmit(v.queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    check(v.vkQueueWaitIdle(v.queue), "vkQueueWaitIdle");

    DrawnFrame frame{width, height, std::vector<uint32_t>(pixels), std::vector<float>(pixels)};
    std::memcpy(frame.ids.data(), v.idsBack.data, pixels * 4);
    std::memcpy(frame.depth.data(), v.depthBack.data, pixels * 4);
    return frame;
}

}  // namespace plumb::oracle
