/* A Vulkan layer that gives a driver VK_KHR_performance_query, for tests: below the validation layer, over lavapipe.
 *
 * Its counters count what they can see, draws and render passes, or add a constant in each submission with the index of their pass;
 * counter n in pass n % PASSES. A pass that is left out or done twice so shows in the numbers.
 * One instance and one device at a time, one thread.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#define EXPORT __attribute__((visibility("default")))
#define LENGTH(array) (sizeof(array) / sizeof(*(array)))
#define OF_DEVICE(name) ((PFN_##name)next_gdpa(device, #name))

static PFN_vkGetInstanceProcAddr next_gipa;
static PFN_vkGetDeviceProcAddr next_gdpa;
static VkInstance instance;
static VkDevice device;
/* Looked up before the loader knows this layer: later some loaders hand out the layer's own. */
static PFN_vkEnumerateDeviceExtensionProperties next_extensions;
static PFN_vkGetPhysicalDeviceFeatures2 next_features;

enum { DRAWS, RENDER_PASSES, COUNTERS = 8, PASSES = 3 };

static const struct {
    const char *name, *category, *description;
    VkPerformanceCounterUnitKHR unit;
    VkPerformanceCounterScopeKHR scope;
    VkPerformanceCounterStorageKHR storage;
    double step;
} counters[COUNTERS] = {
    {"Draws", "Commands", "Draw calls", VK_PERFORMANCE_COUNTER_UNIT_GENERIC_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_KHR, VK_PERFORMANCE_COUNTER_STORAGE_UINT32_KHR, 0},
    {"Render Passes", "Commands", "", VK_PERFORMANCE_COUNTER_UNIT_GENERIC_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_RENDER_PASS_KHR, VK_PERFORMANCE_COUNTER_STORAGE_UINT64_KHR, 0},
    {"Written", "Memory", "Bytes that leave the chip", VK_PERFORMANCE_COUNTER_UNIT_BYTES_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_BUFFER_KHR, VK_PERFORMANCE_COUNTER_STORAGE_UINT64_KHR, 1099511627781.0},
    {"Busy", "Shader", "", VK_PERFORMANCE_COUNTER_UNIT_PERCENTAGE_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_KHR, VK_PERFORMANCE_COUNTER_STORAGE_FLOAT32_KHR, 62.5},
    {"Drift", "Time", "", VK_PERFORMANCE_COUNTER_UNIT_NANOSECONDS_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_BUFFER_KHR, VK_PERFORMANCE_COUNTER_STORAGE_INT64_KHR, -1099511627779.0},
    {"Below", "Heat", "", VK_PERFORMANCE_COUNTER_UNIT_KELVIN_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_BUFFER_KHR, VK_PERFORMANCE_COUNTER_STORAGE_INT32_KHR, -7},
    {"Power", "Core", "", VK_PERFORMANCE_COUNTER_UNIT_WATTS_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_KHR, VK_PERFORMANCE_COUNTER_STORAGE_FLOAT64_KHR, 0.1},
    {"Power", "Memory", "", VK_PERFORMANCE_COUNTER_UNIT_WATTS_KHR,
     VK_PERFORMANCE_COUNTER_SCOPE_COMMAND_KHR, VK_PERFORMANCE_COUNTER_STORAGE_FLOAT64_KHR, 0.2},
};

/* A pool of one query; to the driver it is one of occlusion queries, of which none is begun. */
static struct Pool {
    VkQueryPool raw;
    uint32_t count, chosen[COUNTERS], passes;
    /* Submissions with each pass since the reset. */
    uint32_t submitted[PASSES];
    double sums[COUNTERS];
} pools[4];

/* What a command buffer does with a pool. */
static struct Recorded {
    VkCommandBuffer raw;
    struct Pool *reset, *counted;
    int is_open;
    uint32_t seen[2];
} buffers[16];

static struct Pool *pool_of(VkQueryPool raw) {
    for (size_t i = 0; i < LENGTH(pools); i++)
        if (pools[i].raw == raw) return &pools[i];
    return NULL;
}

/* The record of a command buffer; `make` takes a free one where it has none. */
static struct Recorded *recorded(VkCommandBuffer raw, int make) {
    struct Recorded *free = NULL;
    for (size_t i = 0; i < LENGTH(buffers); i++) {
        if (buffers[i].raw == raw) return &buffers[i];
        if (buffers[i].raw == VK_NULL_HANDLE) free = &buffers[i];
    }
    if (!make) return NULL;
    if (!free) abort();
    *free = (struct Recorded){.raw = raw};
    return free;
}

static uint32_t passes_of(uint32_t count, const uint32_t *chosen) {
    uint32_t passes = 0;
    for (uint32_t i = 0; i < count; i++)
        if (chosen[i] % PASSES >= passes) passes = chosen[i] % PASSES + 1;
    return passes;
}

static VKAPI_ATTR VkResult VKAPI_CALL EnumerateDeviceExtensionProperties(
    VkPhysicalDevice physical, const char *layer, uint32_t *count, VkExtensionProperties *properties) {
    uint32_t room = *count;
    VkResult result = next_extensions(physical, layer, count, properties);
    if (result != VK_SUCCESS) return result;
    if (properties) {
        if (*count == room) return VK_INCOMPLETE;
        VkExtensionProperties ours = {VK_KHR_PERFORMANCE_QUERY_EXTENSION_NAME, VK_KHR_PERFORMANCE_QUERY_SPEC_VERSION};
        properties[*count] = ours;
    }
    *count += 1;
    return VK_SUCCESS;
}

static void *find(const void *chain, VkStructureType type) {
    VkBaseOutStructure *s = (VkBaseOutStructure *)chain;
    while (s && s->sType != type) s = s->pNext;
    return s;
}

static VKAPI_ATTR void VKAPI_CALL GetPhysicalDeviceFeatures2(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2 *features) {
    next_features(physical, features);
    VkPhysicalDevicePerformanceQueryFeaturesKHR *ours =
        find(features->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PERFORMANCE_QUERY_FEATURES_KHR);
    if (ours) ours->performanceCounterQueryPools = VK_TRUE;
}

static VKAPI_ATTR VkResult VKAPI_CALL EnumerateCounters(
    VkPhysicalDevice physical, uint32_t family, uint32_t *count, VkPerformanceCounterKHR *all,
    VkPerformanceCounterDescriptionKHR *descriptions) {
    (void)physical, (void)family;
    if ((all || descriptions) && *count < COUNTERS) return VK_INCOMPLETE;
    for (int i = 0; all && i < COUNTERS; i++) {
        all[i].unit = counters[i].unit;
        all[i].scope = counters[i].scope;
        all[i].storage = counters[i].storage;
        memset(all[i].uuid, i + 1, VK_UUID_SIZE);
    }
    for (int i = 0; descriptions && i < COUNTERS; i++) {
        descriptions[i].flags = i == 2 ? VK_PERFORMANCE_COUNTER_DESCRIPTION_PERFORMANCE_IMPACTING_BIT_KHR : 0;
        strcpy(descriptions[i].name, counters[i].name);
        strcpy(descriptions[i].category, counters[i].category);
        strcpy(descriptions[i].description, counters[i].description);
    }
    *count = COUNTERS;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL GetPasses(
    VkPhysicalDevice physical, const VkQueryPoolPerformanceCreateInfoKHR *info, uint32_t *passes) {
    (void)physical;
    *passes = passes_of(info->counterIndexCount, info->pCounterIndices);
}

static VKAPI_ATTR VkResult VKAPI_CALL AcquireLock(VkDevice of, const VkAcquireProfilingLockInfoKHR *info) {
    (void)of, (void)info;
    return getenv("ONTILE_COUNTERS_LOCKED") ? VK_TIMEOUT : VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL ReleaseLock(VkDevice of) { (void)of; }

static VKAPI_ATTR VkResult VKAPI_CALL CreateQueryPool(
    VkDevice of, const VkQueryPoolCreateInfo *info, const VkAllocationCallbacks *callbacks, VkQueryPool *pool) {
    VkQueryPoolCreateInfo plain = *info;
    const VkQueryPoolPerformanceCreateInfoKHR *ours = NULL;
    if (info->queryType == VK_QUERY_TYPE_PERFORMANCE_QUERY_KHR) {
        ours = find(info->pNext, VK_STRUCTURE_TYPE_QUERY_POOL_PERFORMANCE_CREATE_INFO_KHR);
        plain.queryType = VK_QUERY_TYPE_OCCLUSION;
        plain.pNext = NULL;
    }
    VkResult result = OF_DEVICE(vkCreateQueryPool)(of, &plain, callbacks, pool);
    if (!ours || result != VK_SUCCESS) return result;
    struct Pool *made = pool_of(VK_NULL_HANDLE);
    if (!made || ours->counterIndexCount > COUNTERS || info->queryCount != 1) abort();
    *made = (struct Pool){.raw = *pool, .count = ours->counterIndexCount};
    memcpy(made->chosen, ours->pCounterIndices, made->count * sizeof(uint32_t));
    made->passes = passes_of(made->count, made->chosen);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL DestroyQueryPool(VkDevice of, VkQueryPool pool, const VkAllocationCallbacks *callbacks) {
    struct Pool *ours = pool != VK_NULL_HANDLE ? pool_of(pool) : NULL;
    if (ours) *ours = (struct Pool){0};
    OF_DEVICE(vkDestroyQueryPool)(of, pool, callbacks);
}

static VKAPI_ATTR VkResult VKAPI_CALL BeginCommandBuffer(VkCommandBuffer buffer, const VkCommandBufferBeginInfo *info) {
    struct Recorded *old = recorded(buffer, 0);
    if (old) *old = (struct Recorded){0};
    return OF_DEVICE(vkBeginCommandBuffer)(buffer, info);
}

static VKAPI_ATTR void VKAPI_CALL CmdResetQueryPool(VkCommandBuffer buffer, VkQueryPool pool, uint32_t first, uint32_t count) {
    struct Pool *ours = pool_of(pool);
    if (ours) recorded(buffer, 1)->reset = ours;
    OF_DEVICE(vkCmdResetQueryPool)(buffer, pool, first, count);
}

static VKAPI_ATTR void VKAPI_CALL CmdBeginQuery(
    VkCommandBuffer buffer, VkQueryPool pool, uint32_t query, VkQueryControlFlags flags) {
    struct Pool *ours = pool_of(pool);
    if (!ours) {
        OF_DEVICE(vkCmdBeginQuery)(buffer, pool, query, flags);
        return;
    }
    struct Recorded *here = recorded(buffer, 1);
    here->counted = ours;
    here->is_open = 1;
}

static VKAPI_ATTR void VKAPI_CALL CmdEndQuery(VkCommandBuffer buffer, VkQueryPool pool, uint32_t query) {
    if (pool_of(pool))
        recorded(buffer, 1)->is_open = 0;
    else
        OF_DEVICE(vkCmdEndQuery)(buffer, pool, query);
}

static void see(VkCommandBuffer buffer, int what) {
    struct Recorded *here = recorded(buffer, 0);
    if (here && here->is_open) here->seen[what] += 1;
}

static VKAPI_ATTR void VKAPI_CALL CmdDraw(VkCommandBuffer buffer, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    see(buffer, DRAWS);
    OF_DEVICE(vkCmdDraw)(buffer, a, b, c, d);
}

static VKAPI_ATTR void VKAPI_CALL CmdDrawIndexed(
    VkCommandBuffer buffer, uint32_t a, uint32_t b, uint32_t c, int32_t d, uint32_t e) {
    see(buffer, DRAWS);
    OF_DEVICE(vkCmdDrawIndexed)(buffer, a, b, c, d, e);
}

static VKAPI_ATTR void VKAPI_CALL CmdBeginRenderPass(
    VkCommandBuffer buffer, const VkRenderPassBeginInfo *info, VkSubpassContents contents) {
    see(buffer, RENDER_PASSES);
    OF_DEVICE(vkCmdBeginRenderPass)(buffer, info, contents);
}

static VKAPI_ATTR VkResult VKAPI_CALL QueueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo *submits, VkFence fence) {
    for (uint32_t s = 0; s < count; s++) {
        const VkPerformanceQuerySubmitInfoKHR *info =
            find(submits[s].pNext, VK_STRUCTURE_TYPE_PERFORMANCE_QUERY_SUBMIT_INFO_KHR);
        uint32_t pass = info ? info->counterPassIndex : 0;
        for (uint32_t b = 0; b < submits[s].commandBufferCount; b++) {
            struct Recorded *here = recorded(submits[s].pCommandBuffers[b], 0);
            if (here && here->reset) {
                memset(here->reset->submitted, 0, sizeof here->reset->submitted);
                memset(here->reset->sums, 0, sizeof here->reset->sums);
            }
            struct Pool *pool = here ? here->counted : NULL;
            if (!pool || pass >= pool->passes) continue;
            pool->submitted[pass] += 1;
            for (uint32_t i = 0; i < pool->count; i++) {
                uint32_t counter = pool->chosen[i];
                if (counter % PASSES != pass) continue;
                pool->sums[i] += counter <= RENDER_PASSES ? here->seen[counter] : counters[counter].step;
            }
        }
    }
    return OF_DEVICE(vkQueueSubmit)(queue, count, submits, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL GetQueryPoolResults(
    VkDevice of, VkQueryPool raw, uint32_t first, uint32_t count, size_t size, void *data, VkDeviceSize stride,
    VkQueryResultFlags flags) {
    struct Pool *pool = pool_of(raw);
    if (!pool) return OF_DEVICE(vkGetQueryPoolResults)(of, raw, first, count, size, data, stride, flags);
    for (uint32_t pass = 0; pass < pool->passes; pass++)
        if (!pool->submitted[pass]) return VK_NOT_READY;
    for (uint32_t i = 0; i < pool->count; i++) {
        /* What a storage leaves of the 8 bytes is noise. */
        VkPerformanceCounterResultKHR *value = (VkPerformanceCounterResultKHR *)data + i;
        value->uint64 = 0xabababababababab;
        switch (counters[pool->chosen[i]].storage) {
        case VK_PERFORMANCE_COUNTER_STORAGE_INT32_KHR: value->int32 = (int32_t)pool->sums[i]; break;
        case VK_PERFORMANCE_COUNTER_STORAGE_INT64_KHR: value->int64 = (int64_t)pool->sums[i]; break;
        case VK_PERFORMANCE_COUNTER_STORAGE_UINT32_KHR: value->uint32 = (uint32_t)pool->sums[i]; break;
        case VK_PERFORMANCE_COUNTER_STORAGE_UINT64_KHR: value->uint64 = (uint64_t)pool->sums[i]; break;
        case VK_PERFORMANCE_COUNTER_STORAGE_FLOAT32_KHR: value->float32 = (float)pool->sums[i]; break;
        default: value->float64 = pool->sums[i];
        }
    }
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL CreateInstance(
    const VkInstanceCreateInfo *info, const VkAllocationCallbacks *callbacks, VkInstance *made) {
    VkLayerInstanceCreateInfo *link = find(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    while (link && link->function != VK_LAYER_LINK_INFO)
        link = find(link->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_gipa = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    VkResult result = ((PFN_vkCreateInstance)next_gipa(NULL, "vkCreateInstance"))(info, callbacks, made);
    if (result != VK_SUCCESS) return result;
    instance = *made;
    next_extensions = (PFN_vkEnumerateDeviceExtensionProperties)next_gipa(instance, "vkEnumerateDeviceExtensionProperties");
    next_features = (PFN_vkGetPhysicalDeviceFeatures2)next_gipa(instance, "vkGetPhysicalDeviceFeatures2");
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL CreateDevice(
    VkPhysicalDevice physical, const VkDeviceCreateInfo *info, const VkAllocationCallbacks *callbacks, VkDevice *made) {
    VkLayerDeviceCreateInfo *link = find(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    while (link && link->function != VK_LAYER_LINK_INFO)
        link = find(link->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkCreateDevice next = (PFN_vkCreateDevice)link->u.pLayerInfo->pfnNextGetInstanceProcAddr(instance, "vkCreateDevice");
    next_gdpa = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    /* The driver knows neither extension nor feature. */
    VkDeviceCreateInfo plain = *info;
    const char *names[64];
    plain.ppEnabledExtensionNames = names;
    plain.enabledExtensionCount = 0;
    for (uint32_t i = 0; i < info->enabledExtensionCount && i < LENGTH(names); i++)
        if (strcmp(info->ppEnabledExtensionNames[i], VK_KHR_PERFORMANCE_QUERY_EXTENSION_NAME))
            names[plain.enabledExtensionCount++] = info->ppEnabledExtensionNames[i];
    VkBaseOutStructure *before = (VkBaseOutStructure *)&plain;
    while (before->pNext && before->pNext->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PERFORMANCE_QUERY_FEATURES_KHR)
        before = before->pNext;
    VkBaseOutStructure *ours = before->pNext;
    if (ours) before->pNext = ours->pNext;
    VkResult result = next(physical, &plain, callbacks, made);
    if (ours) before->pNext = ours;
    if (result == VK_SUCCESS) device = *made;
    return result;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice of, const char *name);

/* Functions of devices come after the first six. */
static const struct {
    const char *name;
    PFN_vkVoidFunction function;
} hooks[] = {
    {"vkCreateInstance", (PFN_vkVoidFunction)CreateInstance},
    {"vkCreateDevice", (PFN_vkVoidFunction)CreateDevice},
    {"vkEnumerateDeviceExtensionProperties", (PFN_vkVoidFunction)EnumerateDeviceExtensionProperties},
    {"vkGetPhysicalDeviceFeatures2", (PFN_vkVoidFunction)GetPhysicalDeviceFeatures2},
    {"vkEnumeratePhysicalDeviceQueueFamilyPerformanceQueryCountersKHR", (PFN_vkVoidFunction)EnumerateCounters},
    {"vkGetPhysicalDeviceQueueFamilyPerformanceQueryPassesKHR", (PFN_vkVoidFunction)GetPasses},
    {"vkGetDeviceProcAddr", (PFN_vkVoidFunction)GetDeviceProcAddr},
    {"vkAcquireProfilingLockKHR", (PFN_vkVoidFunction)AcquireLock},
    {"vkReleaseProfilingLockKHR", (PFN_vkVoidFunction)ReleaseLock},
    {"vkCreateQueryPool", (PFN_vkVoidFunction)CreateQueryPool},
    {"vkDestroyQueryPool", (PFN_vkVoidFunction)DestroyQueryPool},
    {"vkBeginCommandBuffer", (PFN_vkVoidFunction)BeginCommandBuffer},
    {"vkCmdResetQueryPool", (PFN_vkVoidFunction)CmdResetQueryPool},
    {"vkCmdBeginQuery", (PFN_vkVoidFunction)CmdBeginQuery},
    {"vkCmdEndQuery", (PFN_vkVoidFunction)CmdEndQuery},
    {"vkCmdDraw", (PFN_vkVoidFunction)CmdDraw},
    {"vkCmdDrawIndexed", (PFN_vkVoidFunction)CmdDrawIndexed},
    {"vkCmdBeginRenderPass", (PFN_vkVoidFunction)CmdBeginRenderPass},
    {"vkQueueSubmit", (PFN_vkVoidFunction)QueueSubmit},
    {"vkGetQueryPoolResults", (PFN_vkVoidFunction)GetQueryPoolResults},
};

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice of, const char *name) {
    for (size_t i = 6; i < LENGTH(hooks); i++)
        if (!strcmp(hooks[i].name, name)) return hooks[i].function;
    return next_gdpa(of, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstanceProcAddr(VkInstance of, const char *name) {
    for (size_t i = 0; i < LENGTH(hooks); i++)
        if (!strcmp(hooks[i].name, name)) return hooks[i].function;
    return next_gipa ? next_gipa(of, name) : NULL;
}

EXPORT VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *negotiated) {
    negotiated->pfnGetInstanceProcAddr = GetInstanceProcAddr;
    negotiated->pfnGetDeviceProcAddr = GetDeviceProcAddr;
    negotiated->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
