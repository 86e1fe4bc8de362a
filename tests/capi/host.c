/* A host in C: makes its own device, embeds ontile, and writes the pixels of two frames.
 *
 *     host DEVICE OUTPUT     DEVICE: a part of the device's name
 *
 * It ends with 77 where there is no such device, with 1 and a message where something is wrong. */
#include "ontile.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 96, BYTES = WIDTH * HEIGHT * 4, FRAMES = 2 };

static int messages = 0;

static VKAPI_ATTR VkBool32 VKAPI_CALL told(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                           VkDebugUtilsMessageTypeFlagsEXT type,
                                           const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    (void)severity, (void)type, (void)user;
    fprintf(stderr, "validation: %s\n", data->pMessage);
    messages++;
    return VK_FALSE;
}

static void check(int holds, const char *what) {
    if (!holds) {
        fprintf(stderr, "%s: %s\n", what, ontile_last_error());
        _Exit(1);
    }
}
#define VK(call) check((call) == VK_SUCCESS, #call)
#define ON(call) check((call) == ONTILE_RESULT_OK, #call)

static VkInstance instance;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static uint32_t family = UINT32_MAX;
static VkDebugUtilsMessengerEXT messenger;

static void make_instance(void) {
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
    const char *layer = "VK_LAYER_KHRONOS_validation", *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    VkDebugUtilsMessengerCreateInfoEXT debug = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = told};
    VkValidationFeatureEnableEXT sync = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                        .pNext = &debug,
                                        .enabledValidationFeatureCount = 1,
                                        .pEnabledValidationFeatures = &sync};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                 .pNext = &features,
                                 .pApplicationInfo = &app,
                                 .enabledLayerCount = 1,
                                 .ppEnabledLayerNames = &layer,
                                 .enabledExtensionCount = 1,
                                 .ppEnabledExtensionNames = &extension};
    if (vkCreateInstance(&info, NULL, &instance) != VK_SUCCESS) exit(77);
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT");
    VK(create(instance, &debug, NULL, &messenger));
}

static void make_device(const char *name) {
    VkPhysicalDevice all[8];
    uint32_t count = 8;
    vkEnumeratePhysicalDevices(instance, &count, all);
    for (uint32_t i = 0; i < count && !physical; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(all[i], &properties);
        if (strstr(properties.deviceName, name)) physical = all[i];
    }
    if (!physical) exit(77);
    VkQueueFamilyProperties families[8];
    count = 8;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
    for (uint32_t i = count; i-- > 0;)
        if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) family = i;
    float priority = 1;
    VkDeviceQueueCreateInfo queues = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                      .queueFamilyIndex = family,
                                      .queueCount = 1,
                                      .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queues};
    VK(vkCreateDevice(physical, &info, NULL, &device));
    vkGetDeviceQueue(device, family, 0, &queue);
}

static VkDeviceMemory memory_for(VkMemoryRequirements needs, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(physical, &types);
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size};
    for (uint32_t i = types.memoryTypeCount; i-- > 0;)
        if ((needs.memoryTypeBits >> i & 1) && (types.memoryTypes[i].propertyFlags & wanted) == wanted)
            info.memoryTypeIndex = i;
    VkDeviceMemory memory;
    VK(vkAllocateMemory(device, &info, NULL, &memory));
    return memory;
}

/* A square of four by four quads, and a light on it. */
static OntileWorld *make_world(OntileId *instance_id) {
    float positions[25 * 3], normals[25 * 3];
    uint32_t indices[16 * 6], n = 0;
    for (int i = 0; i < 25; i++) {
        float corner[3] = {(float)(i % 5) * 0.25f - 0.5f, (float)(i / 5) * 0.25f - 0.5f, 0}, normal[3] = {0, 0, 1};
        memcpy(positions + 3 * i, corner, sizeof corner);
        memcpy(normals + 3 * i, normal, sizeof normal);
        if (i % 5 == 4 || i / 5 == 4) continue;
        uint32_t at = (uint32_t)i, quad[6] = {at, at + 1, at + 6, at, at + 6, at + 5};
        memcpy(indices + n, quad, sizeof quad);
        n += 6;
    }
    OntileWorld *world;
    ON(ontile_world_create("square", &world));
    OntileMaterial material = ontile_material_default();
    float color[4] = {0.8f, 0.4f, 0.2f, 1};
    memcpy(material.base_color_factor, color, sizeof color);
    material.roughness_factor = 0.5f;
    OntileId material_id = 0, mesh_id = 0, light_id = 0;
    ON(ontile_world_set_material(world, &material_id, &material));
    OntileMesh mesh = {.name = "square",
                       .vertex_count = 25,
                       .positions = positions,
                       .normals = normals,
                       .index_count = n,
                       .indices = indices,
                       .material = material_id};
    ON(ontile_world_set_mesh(world, &mesh_id, &mesh));
    OntileInstance placed = {.mesh = mesh_id, .world_from_object = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    ON(ontile_world_set_instance(world, instance_id, &placed));
    OntileLight light = ontile_light_default();
    float position[3] = {0.5f, 0.5f, 1.5f};
    memcpy(light.position, position, sizeof position);
    light.kind = ONTILE_LIGHT_KIND_POINT;
    light.intensity = 6;
    ON(ontile_world_set_light(world, &light_id, &light));

    /* What does not go is refused with a reason, and changes nothing. */
    check(ontile_world_remove(world, ONTILE_KIND_MESH, mesh_id) == ONTILE_RESULT_ERROR_UNSUPPORTED, "a used mesh goes");
    check(strstr(ontile_last_error(), "instances[0] uses it") != NULL, "the reason");
    check(ontile_world_set_mesh(world, &mesh_id, NULL) == ONTILE_RESULT_ERROR_ARGUMENT, "no mesh");
    check(strcmp(ontile_last_error(), "mesh is null") == 0, "the argument");
    OntileId unknown = 12345;
    check(ontile_world_set_light(world, &unknown, &light) == ONTILE_RESULT_ERROR_UNSUPPORTED, "an unknown light");
    OntileWorld *missing = NULL;
    check(ontile_world_load("/no/such.glb", &missing) == ONTILE_RESULT_ERROR_IO && !missing, "a missing file");
    return world;
}

int main(int count, char **arguments) {
    if (count != 3) return 1;
    check(ontile_abi_version() == ONTILE_ABI_VERSION, "the library is of another version than the header");
    make_instance();
    make_device(arguments[1]);

    OntileHost host = {.get_instance_proc_addr = vkGetInstanceProcAddr,
                       .instance = instance,
                       .physical_device = physical,
                       .device = device,
                       .queue_family_index = family,
                       .queue = queue,
                       .features = ONTILE_FEATURE_DEBUG_UTILS};
    OntileDevice *ontile;
    ON(ontile_device_create(&host, &ontile));
    OntileId square = 0;
    OntileWorld *world = make_world(&square);
    OntileOptions *options;
    ON(ontile_options_create(&options));
    check(ontile_options_set(options, "layout", "none") == ONTILE_RESULT_ERROR_UNSUPPORTED, "no such layout");
    ON(ontile_options_set(options, "layout", "packed128"));
    ON(ontile_options_set(options, "size", "160x96"));
    OntilePipelineCache *cache;
    ON(ontile_pipeline_cache_create(ontile, NULL, 0, &cache));
    OntileRenderer *renderer;
    ON(ontile_renderer_create(ontile, world, options, FRAMES, cache, &renderer));
    ON(ontile_world_clear_changes(world));
    size_t blob_bytes = 0, plan_bytes = 0;
    ON(ontile_pipeline_cache_blob(cache, &blob_bytes, NULL));
    ON(ontile_renderer_plan(renderer, &plan_bytes, NULL));
    check(blob_bytes > 0 && plan_bytes > 0, "a cache and a plan");
    OntileOutput output;
    ON(ontile_renderer_output(renderer, &output));

    VkImageCreateInfo image_info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = output.format,
                                    .extent = {WIDTH, HEIGHT, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = output.usage};
    VkImage image;
    VK(vkCreateImage(device, &image_info, NULL, &image));
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device, image, &needs);
    VkDeviceMemory image_memory = memory_for(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VK(vkBindImageMemory(device, image, image_memory, 0));
    VkImageSubresourceRange whole = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageViewCreateInfo view_info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                       .image = image,
                                       .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                       .format = output.format,
                                       .subresourceRange = whole};
    VkImageView view;
    VK(vkCreateImageView(device, &view_info, NULL, &view));
    VkBufferCreateInfo buffer_info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                      .size = FRAMES * BYTES,
                                      .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkBuffer buffer;
    VK(vkCreateBuffer(device, &buffer_info, NULL, &buffer));
    vkGetBufferMemoryRequirements(device, buffer, &needs);
    VkDeviceMemory buffer_memory =
        memory_for(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(device, buffer, buffer_memory, 0));
    OntileOutputImage output_image = {image, view};
    OntileTarget *target;
    ON(ontile_target_create(renderer, WIDTH, HEIGHT, &output_image, 1, &target));

    VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = family};
    VkCommandPool pool;
    VK(vkCreateCommandPool(device, &pool_info, NULL, &pool));
    VkCommandBuffer commands[FRAMES];
    VkCommandBufferAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                            .commandPool = pool,
                                            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                            .commandBufferCount = FRAMES};
    VK(vkAllocateCommandBuffers(device, &allocate, commands));
    OntileCamera camera = {.world_from_view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1},
                           .projection = ONTILE_PROJECTION_PERSPECTIVE,
                           .vertical = 1,
                           .z_near = 0.1f};
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        VK(vkBeginCommandBuffer(commands[frame], &begin));
        if (frame == 0) {
            ON(ontile_renderer_record_upload(renderer, commands[frame]));
        } else {
            float moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.3f, 0.1f, -0.5f, 1};
            ON(ontile_world_place(world, square, moved));
            OntileUpdated updated;
            ON(ontile_renderer_update(renderer, world, commands[frame], &updated));
            check(!updated.new_targets && !updated.new_objects, "moving makes nothing");
            ON(ontile_world_clear_changes(world));
        }
        check(ontile_renderer_record(renderer, commands[frame], FRAMES, target, 0, &camera, 0) ==
                  ONTILE_RESULT_ERROR_ARGUMENT, "a slot beyond the last");
        ON(ontile_renderer_record(renderer, commands[frame], frame, target, 0, &camera, 0));
        VkBufferImageCopy region = {.bufferOffset = frame * BYTES,
                                    .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                    .imageExtent = {WIDTH, HEIGHT, 1}};
        vkCmdCopyImageToBuffer(commands[frame], image, output.layout, buffer, 1, &region);
        VkMemoryBarrier to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                   .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                   .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
        vkCmdPipelineBarrier(commands[frame], VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host,
                             0, NULL, 0, NULL);
        VK(vkEndCommandBuffer(commands[frame]));
        VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &commands[frame]};
        VK(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE));
    }
    VK(vkQueueWaitIdle(queue));
    ON(ontile_renderer_finish_upload(renderer));

    void *pixels;
    VK(vkMapMemory(device, buffer_memory, 0, VK_WHOLE_SIZE, 0, &pixels));
    FILE *file = fopen(arguments[2], "wb");
    check(file && fwrite(pixels, BYTES, FRAMES, file) == FRAMES && fclose(file) == 0, "writing the pixels");

    ontile_target_destroy(target);
    ontile_renderer_destroy(renderer);
    ontile_pipeline_cache_destroy(cache);
    ontile_options_destroy(options);
    ontile_world_destroy(world);
    uint64_t objects = 1, bytes = 1;
    ON(ontile_device_live(ontile, &objects, &bytes));
    check(objects == 0 && bytes == 0, "objects are left");
    ontile_device_destroy(ontile);
    vkDestroyCommandPool(device, pool, NULL);
    vkDestroyBuffer(device, buffer, NULL);
    vkFreeMemory(device, buffer_memory, NULL);
    vkDestroyImageView(device, view, NULL);
    vkDestroyImage(device, image, NULL);
    vkFreeMemory(device, image_memory, NULL);
    vkDestroyDevice(device, NULL);
    ((PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"))(
        instance, messenger, NULL);
    vkDestroyInstance(instance, NULL);
    check(messages == 0, "the validation layer said something");
    return 0;
}
