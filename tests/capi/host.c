/* A host in C: makes its own device, embeds ontile, and writes the pixels of four frames, RGBA with 8 bits a channel.
 *
 *     host DEVICE OUTPUT KTX2 SCENE HDR
 *
 * DEVICE is a part of the device's name. Two frames show a square that has the picture KTX2 on it and reflects HDR, two show how
 * the first animation moves SCENE. It ends with 77 where there is no such device, with 1 and a message where something is wrong. */
#include "ontile.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 96, BYTES = WIDTH * HEIGHT * 4, FRAMES = 2, WORLDS = 2 };

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

#include "ahead.h"

static VkInstance instance;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static uint32_t family = UINT32_MAX;
static uint32_t features = ONTILE_FEATURE_DEBUG_UTILS;
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
    /* What is not enabled is done without: compressed pictures become RGBA8 then, and shadow volumes maps. */
    VkPhysicalDeviceFeatures has, enabled = {0};
    vkGetPhysicalDeviceFeatures(physical, &has);
    enabled.textureCompressionBC = has.textureCompressionBC;
    if (has.textureCompressionBC) features |= ONTILE_FEATURE_TEXTURE_COMPRESSION_BC;
    enabled.imageCubeArray = has.imageCubeArray;
    if (has.imageCubeArray) features |= ONTILE_FEATURE_IMAGE_CUBE_ARRAY;
    enabled.depthClamp = enabled.shaderClipDistance = has.depthClamp && has.shaderClipDistance;
    if (enabled.depthClamp) features |= ONTILE_FEATURE_DEPTH_CLAMP;
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pEnabledFeatures = &enabled,
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

static OntileId read_image(OntileWorld *world, const char *path) {
    FILE *file = fopen(path, "rb");
    check(file && fseek(file, 0, SEEK_END) == 0, path);
    long bytes = ftell(file);
    rewind(file);
    uint8_t *content = malloc((size_t)bytes);
    check(content && fread(content, (size_t)bytes, 1, file) == 1 && fclose(file) == 0, path);
    OntileImage picture = {.name = "tiles", .ktx2 = content, .ktx2_bytes = (size_t)bytes};
    OntileId image = 0;
    ON(ontile_world_set_image(world, &image, &picture));
    free(content);
    return image;
}

static OntileId square = 0;

/* A square of four by four quads with a picture, and a light on it. */
static OntileWorld *make_world(const char *picture, const char *around) {
    float positions[25 * 3], normals[25 * 3], texcoords[25 * 2];
    uint32_t indices[16 * 6], n = 0;
    for (int i = 0; i < 25; i++) {
        float corner[3] = {(float)(i % 5) * 0.25f - 0.5f, (float)(i / 5) * 0.25f - 0.5f, 0}, normal[3] = {0, 0, 1};
        memcpy(positions + 3 * i, corner, sizeof corner);
        memcpy(normals + 3 * i, normal, sizeof normal);
        texcoords[2 * i] = corner[0] + 0.5f, texcoords[2 * i + 1] = corner[1] + 0.5f;
        if (i % 5 == 4 || i / 5 == 4) continue;
        uint32_t at = (uint32_t)i, quad[6] = {at, at + 1, at + 6, at, at + 6, at + 5};
        memcpy(indices + n, quad, sizeof quad);
        n += 6;
    }
    OntileWorld *world;
    ON(ontile_world_create("square", &world));
    OntileTexture texture = {
        .image = read_image(world, picture), .mag_linear = true, .min_linear = true, .mips = ONTILE_MIPS_LINEAR};
    OntileId texture_id = 0;
    ON(ontile_world_set_texture(world, &texture_id, &texture));
    OntileMaterial material = ontile_material_default();
    material.base_color_texture.texture = texture_id;
    float color[4] = {0.8f, 0.4f, 0.2f, 1};
    memcpy(material.base_color_factor, color, sizeof color);
    material.roughness_factor = 0.5f;
    OntileId material_id = 0, mesh_id = 0, light_id = 0;
    ON(ontile_world_set_material(world, &material_id, &material));
    OntileMesh mesh = {.name = "square",
                       .vertex_count = 25,
                       .positions = positions,
                       .normals = normals,
                       .texcoords_0 = texcoords,
                       .index_count = n,
                       .indices = indices,
                       .material = material_id};
    ON(ontile_world_set_mesh(world, &mesh_id, &mesh));
    OntileInstance placed = {.mesh = mesh_id, .world_from_object = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    ON(ontile_world_set_instance(world, &square, &placed));
    OntileLight light = ontile_light_default();
    float position[3] = {0.5f, 0.5f, 1.5f};
    memcpy(light.position, position, sizeof position);
    light.kind = ONTILE_LIGHT_KIND_POINT;
    light.intensity = 6;
    ON(ontile_world_set_light(world, &light_id, &light));

    OntileProbe probe = {
        .position = {0, 0, 0.5f}, .rotation = {0, 0, 0, 1}, .half_size = {2, 1, 1}, .falloff = 0.25f, .path = around};
    ON(ontile_world_set_probes(world, &probe, 1));

    /* What does not go is refused with a reason, and changes nothing. */
    check(ontile_world_remove(world, ONTILE_KIND_MESH, mesh_id) == ONTILE_RESULT_ERROR_UNSUPPORTED, "a used mesh goes");
    check(strstr(ontile_last_error(), "instances[0] uses it") != NULL, "the reason");
    check(ontile_world_set_mesh(world, &mesh_id, NULL) == ONTILE_RESULT_ERROR_ARGUMENT, "no mesh");
    check(strcmp(ontile_last_error(), "mesh is null") == 0, "the argument");
    OntileId unknown = 12345;
    check(ontile_world_set_light(world, &unknown, &light) == ONTILE_RESULT_ERROR_UNSUPPORTED, "an unknown light");
    probe.path = "/no/such.hdr";
    check(ontile_world_set_probes(world, &probe, 1) == ONTILE_RESULT_ERROR_IO, "a probe without a picture");
    OntileWorld *missing = NULL;
    check(ontile_world_load("/no/such.glb", &missing) == ONTILE_RESULT_ERROR_IO && !missing, "a missing file");
    return world;
}

static VkImage image;
static VkImageView view;
static VkDeviceMemory image_memory, buffer_memory;
static VkBuffer buffer;
static VkCommandPool pool;
static VkCommandBuffer commands[FRAMES];

/* What frames of both worlds are drawn to (base colours may lie in it first), and where their pixels are read. */
static void make_resources(OntileOutput output) {
    VkImageCreateInfo image_info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = output.format,
                                    .extent = {WIDTH, HEIGHT, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = output.usage | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT};
    VK(vkCreateImage(device, &image_info, NULL, &image));
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device, image, &needs);
    image_memory = memory_for(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VK(vkBindImageMemory(device, image, image_memory, 0));
    VkImageSubresourceRange whole = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageViewCreateInfo view_info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                       .image = image,
                                       .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                       .format = output.format,
                                       .subresourceRange = whole};
    VK(vkCreateImageView(device, &view_info, NULL, &view));
    VkBufferCreateInfo buffer_info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                      .size = WORLDS * FRAMES * BYTES,
                                      .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VK(vkCreateBuffer(device, &buffer_info, NULL, &buffer));
    vkGetBufferMemoryRequirements(device, buffer, &needs);
    buffer_memory =
        memory_for(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(device, buffer, buffer_memory, 0));
    VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                         .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                         .queueFamilyIndex = family};
    VK(vkCreateCommandPool(device, &pool_info, NULL, &pool));
    VkCommandBufferAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                            .commandPool = pool,
                                            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                            .commandBufferCount = FRAMES};
    VK(vkAllocateCommandBuffers(device, &allocate, commands));
}

/* The square moves, and the second picture is upside down: the screen was turned. */
static void move_square(OntileWorld *world, OntileTarget *target) {
    float moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.3f, 0.1f, -0.5f, 1};
    ON(ontile_world_place(world, square, moved));
    check(ontile_target_pre_rotate(target, 45) == ONTILE_RESULT_ERROR_ARGUMENT, "an eighth of a turn");
    ON(ontile_target_pre_rotate(target, 180));
}

static void play(OntileWorld *world, OntileTarget *target) {
    (void)target;
    ON(ontile_world_animate(world, 0, 1.25));
    check(ontile_world_animate(world, 99, 0) == ONTILE_RESULT_ERROR_UNSUPPORTED, "no such animation");
}

/* Draws a world as it is, and again after a change; `number` says where the pixels go. The first world has a triangle over it; of the second
 * each half of the picture is drawn by a renderer of its own. */
static void draw(OntileDevice *ontile, OntileWorld *world, const OntileCamera *camera, uint32_t number,
                 void (*change)(OntileWorld *, OntileTarget *)) {
    OntileOptions *options;
    ON(ontile_options_create(&options));
    check(ontile_options_set(options, "layout", "none") == ONTILE_RESULT_ERROR_UNSUPPORTED, "no such layout");
    ON(ontile_options_set(options, "layout", "ontile128"));
    ON(ontile_options_set(options, "size", "160x96"));
    OntilePipelineCache *cache;
    ON(ontile_pipeline_cache_create(ontile, NULL, 0, &cache));
    ON(ontile_options_set(options, "overlay", number == 0 ? "true" : "false"));
    ask_ahead(ontile, world, options, cache, number == 0);
    const uint32_t halves = number + 1;
    OntileRenderer *renderers[2];
    OntileTarget *targets[2];
    OntileOutput output;
    for (uint32_t half = 0; half < halves; half++) {
        ON(ontile_options_set(options, "output-is-kept", half == 0 ? "false" : "true"));
        ON(ontile_renderer_create(ontile, world, options, FRAMES, cache, &renderers[half]));
        check_plan(ontile, world, options, renderers[half]);
        ON(ontile_renderer_output(renderers[half], &output));
        if (!image) make_resources(output);
        OntileOutputImage output_image = {image, view};
        ON(ontile_target_create(renderers[half], WIDTH, HEIGHT, &output_image, 1, &targets[half]));
    }
    /* What would show the difference from another picture wants that picture. */
    ON(ontile_options_set(options, "difference", "8"));
    OntileRenderer *beside;
    OntileTarget *difference;
    OntileOutputImage own = {image, view};
    ON(ontile_renderer_create(ontile, world, options, 1, cache, &beside));
    check(ontile_target_create(beside, WIDTH, HEIGHT, &own, 1, &difference) == ONTILE_RESULT_ERROR_UNSUPPORTED, "no other");
    ON(ontile_target_create_beside(beside, WIDTH, HEIGHT, &own, 1, view, &difference));
    ontile_target_destroy(difference);
    ontile_renderer_destroy(beside);
    ON(ontile_world_clear_changes(world));
    size_t blob_bytes = 0;
    ON(ontile_pipeline_cache_blob(cache, &blob_bytes, NULL));
    check(blob_bytes > 0, "a cache");
    uint8_t texels[8] = {255, 255, 255, 255, 255, 0, 0, 255};
    check((ontile_renderer_set_overlay_image(renderers[0], 2, 1, texels, 8) == ONTILE_RESULT_OK) == (number == 0),
          "an overlay's image");

    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        VK(vkBeginCommandBuffer(commands[frame], &begin));
        if (frame > 0) change(world, targets[0]);
        for (uint32_t half = 0; half < halves; half++) {
            OntileRenderer *renderer = renderers[half];
            if (frame == 0) {
                ON(ontile_renderer_record_upload(renderer, commands[frame]));
            } else {
                OntileUpdated updated;
                ON(ontile_renderer_update(renderer, world, commands[frame], &updated));
                check(!updated.new_targets && !updated.new_objects, "moving makes nothing");
            }
            ON(ontile_renderer_set_queries(renderer, frame == 0));
            if (number == 0) draw_over(renderer, frame);
            check(ontile_renderer_record(renderer, commands[frame], FRAMES, targets[half], 0, camera, 0) ==
                      ONTILE_RESULT_ERROR_ARGUMENT, "a slot beyond the last");
            uint32_t nothing[4] = {WIDTH, 0, WIDTH + 1, HEIGHT};
            check(ontile_renderer_record_part(renderer, commands[frame], frame, targets[half], 0, camera, 0, nothing) ==
                      ONTILE_RESULT_ERROR_ARGUMENT, "a part beside the picture");
            uint32_t part[4] = {half * WIDTH / 2, 0, (half + 1) * WIDTH / halves, HEIGHT};
            if (halves == 1)
                ON(ontile_renderer_record(renderer, commands[frame], frame, targets[half], 0, camera, 0));
            else
                ON(ontile_renderer_record_part(renderer, commands[frame], frame, targets[half], 0, camera, 0, part));
        }
        ON(ontile_world_clear_changes(world));
        VkBufferImageCopy region = {.bufferOffset = (number * FRAMES + frame) * BYTES,
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
    double time = 0;
    ON(ontile_renderer_frame_time(renderers[0], 0, &time));
    check(time > 0, "a time");
    for (uint32_t half = 0; half < halves; half++) {
        ON(ontile_renderer_finish_upload(renderers[half]));
        ontile_target_destroy(targets[half]);
        ontile_renderer_destroy(renderers[half]);
    }
    ontile_pipeline_cache_destroy(cache);
    ontile_options_destroy(options);
}

int main(int count, char **arguments) {
    if (count != 6) return 1;
    check(ontile_abi_version() == ONTILE_ABI_VERSION, "the library is of another version than the header");
    make_instance();
    make_device(arguments[1]);

    OntileHost host = {.get_instance_proc_addr = vkGetInstanceProcAddr,
                       .instance = instance,
                       .physical_device = physical,
                       .device = device,
                       .queue_family_index = family,
                       .queue = queue,
                       .features = features};
    OntileDevice *ontile;
    ON(ontile_device_create(&host, &ontile));
    OntileWorld *world = make_world(arguments[3], arguments[5]);
    OntileCamera camera = {.world_from_view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1},
                           .projection = ONTILE_PROJECTION_PERSPECTIVE,
                           .vertical = 1,
                           .z_near = 0.1f};
    draw(ontile, world, &camera, 0, move_square);
    ontile_world_destroy(world);

    ON(ontile_world_load_moving(arguments[4], &world));
    size_t ids = 1, bytes = 0;
    OntileId camera_id;
    ON(ontile_world_ids(world, ONTILE_KIND_CAMERA, &ids, &camera_id));
    ON(ontile_world_camera(world, camera_id, &camera));
    ON(ontile_world_animations(world, &bytes, NULL));
    check(bytes > 0, "animations");
    ON(ontile_world_animate(world, 0, 0));
    draw(ontile, world, &camera, 1, play);
    ontile_world_destroy(world);

    void *pixels;
    VK(vkMapMemory(device, buffer_memory, 0, VK_WHOLE_SIZE, 0, &pixels));
    FILE *file = fopen(arguments[2], "wb");
    check(file && fwrite(pixels, BYTES, WORLDS * FRAMES, file) == WORLDS * FRAMES && fclose(file) == 0,
          "writing the pixels");

    uint64_t objects = 1, left_bytes = 1;
    ON(ontile_device_live(ontile, &objects, &left_bytes));
    check(objects == 0 && left_bytes == 0, "objects are left");
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
