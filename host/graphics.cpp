// SPDX-License-Identifier: MIT
#include "host/graphics.h"

#include "host/vulkan.h"

#include <fmt/core.h>

#include <algorithm>

namespace plumb {

struct GraphicsImpl {
    struct Target {
        VkImage image = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkImageView view = VK_NULL_HANDLE;
    };

    Device& owner;
    DeviceImpl& device;
    VkFormat colourFormat;
    uint32_t pushBytes;
    VkRenderPass renderPass = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    Target colourTarget, depthTarget;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    Buffer<uint32_t> colourBack;
    Buffer<float> depthBack;
    uint32_t width = 0, height = 0;
    bool recorded = false, withDepth = false;

    GraphicsImpl(Device& d, const GraphicsSetup& setup)
        : owner(d),
          device(d.impl()),
          colourFormat(setup.wordColour ? VK_FORMAT_R32_UINT : VK_FORMAT_R8G8B8A8_UNORM),
          pushBytes(setup.pushBytes) {
        if (!device.queueDraws) throw deviceError(fmt::format("device '{}' has no graphics pipeline on its queue", device.info.name));
        if (pushBytes > device.limits.pushConstantBytes)
            throw deviceError(fmt::format("device '{}' allows {} bytes of push constants, the graphics pipeline takes {}", device.info.name,
                                          device.limits.pushConstantBytes, pushBytes));
        try {
            createCommands();
            createRenderPass();
            createPipeline(setup);
        } catch (...) {
            destroy();
            throw;
        }
    }
    ~GraphicsImpl() {
        if (device.hung && fence && device.vk.vkWaitForFences(device.handle, 1, &fence, VK_TRUE, uint64_t(kGraceMs * 1e6)) == VK_SUCCESS)
            device.hung = false;
        if (!device.hung) destroy();
    }
    GraphicsImpl(const GraphicsImpl&) = delete;
    GraphicsImpl& operator=(const GraphicsImpl&) = delete;

    void destroy() {
        const VolkDeviceTable& vk = device.vk;
        releaseTargets();
        vk.vkDestroyPipeline(device.handle, pipeline, nullptr);
        vk.vkDestroyPipelineLayout(device.handle, layout, nullptr);
        vk.vkDestroyRenderPass(device.handle, renderPass, nullptr);
        vk.vkDestroyFence(device.handle, fence, nullptr);
        vk.vkDestroyCommandPool(device.handle, pool, nullptr);
    }

    void releaseTargets() {
        const VolkDeviceTable& vk = device.vk;
        vk.vkDestroyFramebuffer(device.handle, framebuffer, nullptr);
        framebuffer = VK_NULL_HANDLE;
        for (Target* target : {&colourTarget, &depthTarget}) {
            vk.vkDestroyImageView(device.handle, target->view, nullptr);
            vk.vkDestroyImage(device.handle, target->image, nullptr);
            vk.vkFreeMemory(device.handle, target->memory, nullptr);
            *target = {};
        }
        width = height = 0;
    }

    void createCommands() {
        const VkCommandPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr,
                                               VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, device.queueFamily};
        VK_CHECK(device.vk.vkCreateCommandPool(device.handle, &poolInfo, nullptr, &pool));
        const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                               VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        VK_CHECK(device.vk.vkAllocateCommandBuffers(device.handle, &info, &commands));
        const VkFenceCreateInfo fenceInfo{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        VK_CHECK(device.vk.vkCreateFence(device.handle, &fenceInfo, nullptr, &fence));
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
        attachments[0].format = colourFormat;
        attachments[1].format = VK_FORMAT_D32_SFLOAT;
        const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
        VkSubpassDescription subpass{};
        subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &colour;
        subpass.pDepthStencilAttachment = &depth;
        // Dependencies between frames: the copies of the frame before have read the images that this one clears, and its own copies read
        // what this one draws.
        std::array<VkSubpassDependency, 2> edges{};
        edges[0].srcSubpass = VK_SUBPASS_EXTERNAL;
        edges[0].srcStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
        edges[0].dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT;
        edges[0].srcAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        edges[0].dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
        edges[1].dstSubpass = VK_SUBPASS_EXTERNAL;
        edges[1].srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
        edges[1].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
        edges[1].dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
        edges[1].dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
        info.attachmentCount = attachments.size();
        info.pAttachments = attachments.data();
        info.subpassCount = 1;
        info.pSubpasses = &subpass;
        info.dependencyCount = edges.size();
        info.pDependencies = edges.data();
        VK_CHECK(device.vk.vkCreateRenderPass(device.handle, &info, nullptr, &renderPass));
    }

    VkShaderModule shader(std::span<const uint32_t> words) const {
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = words.size_bytes();
        info.pCode = words.data();
        VkShaderModule made = VK_NULL_HANDLE;
        VK_CHECK(device.vk.vkCreateShaderModule(device.handle, &info, nullptr, &made));
        return made;
    }

    void createPipeline(const GraphicsSetup& setup) {
        const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, pushBytes};
        VkPipelineLayoutCreateInfo layoutInfo{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        layoutInfo.pushConstantRangeCount = pushBytes != 0 ? 1 : 0;
        layoutInfo.pPushConstantRanges = &range;
        VK_CHECK(device.vk.vkCreatePipelineLayout(device.handle, &layoutInfo, nullptr, &layout));

        std::vector<VkSpecializationMapEntry> entries;
        for (uint32_t i = 0; i < setup.fragmentConstants.size(); ++i) entries.push_back({i, i * 4, 4});
        const VkSpecializationInfo constants{uint32_t(entries.size()), entries.data(), entries.size() * 4, setup.fragmentConstants.data()};
        std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
        for (auto& stage : stages) {
            stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
            stage.pName = "main";
        }
        stages[1].pSpecializationInfo = &constants;
        const VkVertexInputBindingDescription binding{0, setup.vertexBytes, VK_VERTEX_INPUT_RATE_VERTEX};
        std::vector<VkVertexInputAttributeDescription> attributes;
        for (const VertexInput& input : setup.inputs)
            attributes.push_back({uint32_t(attributes.size()), 0,
                                  input.format == VertexFormat::float3   ? VK_FORMAT_R32G32B32_SFLOAT
                                  : input.format == VertexFormat::float4 ? VK_FORMAT_R32G32B32A32_SFLOAT
                                                                         : VK_FORMAT_R32_UINT,
                                  input.offset});
        VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
        input.vertexBindingDescriptionCount = 1;
        input.pVertexBindingDescriptions = &binding;
        input.vertexAttributeDescriptionCount = uint32_t(attributes.size());
        input.pVertexAttributeDescriptions = attributes.data();
        VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
        assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
        viewport.viewportCount = viewport.scissorCount = 1;
        VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
        raster.polygonMode = VK_POLYGON_MODE_FILL;
        raster.cullMode = setup.cullBackFaces ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
        raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
        raster.lineWidth = 1.0f;
        VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
        samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
        VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
        depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
        depth.depthCompareOp = VK_COMPARE_OP_GREATER;
        VkPipelineColorBlendAttachmentState write{};
        write.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
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
        stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
        stages[0].module = shader(setup.vertexWords);
        stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
        try {
            stages[1].module = shader(setup.fragmentWords);
        } catch (...) {
            device.vk.vkDestroyShaderModule(device.handle, stages[0].module, nullptr);
            throw;
        }
        const VkResult made = device.vk.vkCreateGraphicsPipelines(device.handle, device.pipelineCache, 1, &info, nullptr, &pipeline);
        for (const auto& stage : stages) device.vk.vkDestroyShaderModule(device.handle, stage.module, nullptr);
        if (made != VK_SUCCESS) throw renderError(fmt::format("{} from vkCreateGraphicsPipelines", resultName(made)));
    }

    void create(Target& target, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect) {
        VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        info.imageType = VK_IMAGE_TYPE_2D;
        info.format = format;
        info.extent = {width, height, 1};
        info.mipLevels = info.arrayLayers = 1;
        info.samples = VK_SAMPLE_COUNT_1_BIT;
        info.usage = usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
        VK_CHECK(device.vk.vkCreateImage(device.handle, &info, nullptr, &target.image));
        VkMemoryRequirements need;
        device.vk.vkGetImageMemoryRequirements(device.handle, target.image, &need);
        if (need.memoryTypeBits == 0) throw renderError("no memory type fits the attachments of the graphics pipeline");
        VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocate.allocationSize = need.size;
        for (allocate.memoryTypeIndex = 0; !(need.memoryTypeBits >> allocate.memoryTypeIndex & 1u);) ++allocate.memoryTypeIndex;
        VK_CHECK(device.vk.vkAllocateMemory(device.handle, &allocate, nullptr, &target.memory));
        VK_CHECK(device.vk.vkBindImageMemory(device.handle, target.image, target.memory, 0));
        VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
        view.image = target.image;
        view.viewType = VK_IMAGE_VIEW_TYPE_2D;
        view.format = format;
        view.subresourceRange = {aspect, 0, 1, 0, 1};
        VK_CHECK(device.vk.vkCreateImageView(device.handle, &view, nullptr, &target.view));
    }

    void resize(uint32_t newWidth, uint32_t newHeight) {
        if (newWidth == width && newHeight == height) return;
        releaseTargets();
        width = newWidth;
        height = newHeight;
        create(colourTarget, colourFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
        create(depthTarget, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT);
        const std::array<VkImageView, 2> views{colourTarget.view, depthTarget.view};
        VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
        info.renderPass = renderPass;
        info.attachmentCount = views.size();
        info.pAttachments = views.data();
        info.width = width;
        info.height = height;
        info.layers = 1;
        VK_CHECK(device.vk.vkCreateFramebuffer(device.handle, &info, nullptr, &framebuffer));
        colourBack.reserve(owner, uint64_t(width) * height, "colour of the graphics pipeline");
    }

    void copyBack(const Target& target, VkImageAspectFlags aspect, const RawBuffer& to) const {
        VkBufferImageCopy region{};
        region.imageSubresource = {aspect, 0, 0, 1};
        region.imageExtent = {width, height, 1};
        device.vk.vkCmdCopyImageToBuffer(commands, target.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.impl().block->buffer, 1, &region);
    }
};

GraphicsPipeline::GraphicsPipeline(Device& device, const GraphicsSetup& setup) : impl_(std::make_unique<GraphicsImpl>(device, setup)) {}
GraphicsPipeline::~GraphicsPipeline() = default;

void GraphicsPipeline::record(uint32_t width, uint32_t height, const std::array<float, 4>& viewport, uint32_t clearColour,
                              const RawBuffer& vertices, const Buffer<uint32_t>& indices, std::span<const GraphicsDraw> draws,
                              bool copyDepth) {
    GraphicsImpl& g = *impl_;
    const VolkDeviceTable& vk = g.device.vk;
    g.recorded = false;
    g.resize(width, height);
    g.withDepth = copyDepth;
    if (copyDepth) g.depthBack.reserve(g.owner, uint64_t(width) * height, "depth of the graphics pipeline");
    const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VK_CHECK(vk.vkBeginCommandBuffer(g.commands, &begin));
    std::array<VkClearValue, 2> clear{};
    if (g.colourFormat == VK_FORMAT_R32_UINT) {
        clear[0].color.uint32[0] = clearColour;
    } else {
        for (int i = 0; i < 4; ++i) clear[0].color.float32[i] = float(clearColour >> (8 * i) & 0xffu) / 255.0f;
    }
    clear[1].depthStencil.depth = 0.0f;
    VkRenderPassBeginInfo pass{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    pass.renderPass = g.renderPass;
    pass.framebuffer = g.framebuffer;
    pass.renderArea.extent = {width, height};
    pass.clearValueCount = clear.size();
    pass.pClearValues = clear.data();
    vk.vkCmdBeginRenderPass(g.commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
    const VkViewport area{viewport[0], viewport[1], viewport[2], viewport[3], 0, 1};
    const VkRect2D scissor{{0, 0}, {width, height}};
    const VkDeviceSize offset = 0;
    vk.vkCmdBindPipeline(g.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, g.pipeline);
    vk.vkCmdSetViewport(g.commands, 0, 1, &area);
    vk.vkCmdSetScissor(g.commands, 0, 1, &scissor);
    vk.vkCmdBindVertexBuffers(g.commands, 0, 1, &vertices.impl().block->buffer, &offset);
    vk.vkCmdBindIndexBuffer(g.commands, indices.impl().block->buffer, 0, VK_INDEX_TYPE_UINT32);
    for (const GraphicsDraw& draw : draws) {
        PLUMB_ASSERT(draw.push.size() * 4 == g.pushBytes);
        if (g.pushBytes != 0)
            vk.vkCmdPushConstants(g.commands, g.layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, g.pushBytes,
                                  draw.push.data());
        vk.vkCmdDrawIndexed(g.commands, draw.indexCount, 1, draw.firstIndex, 0, 0);
    }
    vk.vkCmdEndRenderPass(g.commands);
    g.copyBack(g.colourTarget, VK_IMAGE_ASPECT_COLOR_BIT, g.colourBack);
    if (copyDepth) g.copyBack(g.depthTarget, VK_IMAGE_ASPECT_DEPTH_BIT, g.depthBack);
    const VkMemoryBarrier toHost{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    vk.vkCmdPipelineBarrier(g.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &toHost, 0, nullptr, 0, nullptr);
    VK_CHECK(vk.vkEndCommandBuffer(g.commands));
    g.recorded = true;
}

void GraphicsPipeline::run(double watchdogMs) {
    GraphicsImpl& g = *impl_;
    const VolkDeviceTable& vk = g.device.vk;
    PLUMB_ASSERT(g.recorded);
    if (g.device.hung) throw renderError("the device may still be busy: the end of its last work was not seen");
    VK_CHECK(vk.vkResetFences(g.device.handle, 1, &g.fence));
    const VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO, nullptr, 0, nullptr, nullptr, 1, &g.commands, 0, nullptr};
    VK_CHECK(vk.vkQueueSubmit(g.device.queue, 1, &submit, g.fence));
    const VkResult waited = vk.vkWaitForFences(g.device.handle, 1, &g.fence, VK_TRUE, uint64_t(std::clamp(watchdogMs * 1e6, 0.0, 1e18)));
    if (waited == VK_SUCCESS) return;
    g.device.hung = true;  // whatever the wait failed with, the work may run on; the destructor waits once more
    throw renderError(fmt::format("graphics pipeline: {} while waiting for the device", resultName(waited)));
}

std::span<const uint32_t> GraphicsPipeline::colour() const { return impl_->colourBack.span().first(size_t(impl_->width) * impl_->height); }
std::span<const float> GraphicsPipeline::depth() const {
    return impl_->withDepth ? impl_->depthBack.span().first(size_t(impl_->width) * impl_->height) : std::span<const float>();
}

}  // namespace plumb
