/* Runs a kinematics module of LinuxCNC outside of LinuxCNC: stands in for HAL, loads the module, and prints the joints
 * of the poses "x y z a b c" (mm, degrees) on stdin, one a line.
 *
 *   kins MODULE.so COORDINATES [PIN=VALUE…] */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { double x, y, z, a, b, c, u, v, w; } Pose;

static struct { char name[64]; void *cell; } pins[64];
static int pin_count;

static int add(void **pin, const char *name)
{
    if (pin_count == 64) return -1;
    *pin = calloc(1, 8);
    snprintf(pins[pin_count].name, sizeof pins[pin_count].name, "%s", name);
    pins[pin_count++].cell = *pin;
    return 0;
}

void *hal_malloc(long size) { return calloc(1, size); }
int hal_init(const char *name) { (void)name; return 1; }
int hal_ready(int id) { (void)id; return 0; }
int hal_exit(int id) { (void)id; return 0; }
void rtapi_print(const char *format, ...) { (void)format; }
void rtapi_print_msg(int level, const char *format, ...)
{
    va_list rest;
    va_start(rest, format);
    if (level <= 1) vfprintf(stderr, format, rest);
    va_end(rest);
}
#define NAMED_PIN(function) \
    int function(int dir, void **pin, int id, const char *format, ...) \
    { \
        char name[64]; \
        va_list rest; \
        (void)dir, (void)id; \
        va_start(rest, format); \
        vsnprintf(name, sizeof name, format, rest); \
        va_end(rest); \
        return add(pin, name); \
    }
#define PIN(function) \
    int function(const char *name, int dir, void **pin, int id) { (void)dir, (void)id; return add(pin, name); }
NAMED_PIN(hal_pin_float_newf)
NAMED_PIN(hal_pin_bit_newf)
PIN(hal_pin_bit_new)
PIN(hal_pin_s32_new)
PIN(hal_pin_float_new)

int main(int count, char **given)
{
    if (count < 3) return 2;
    void *module = dlopen(given[1], RTLD_NOW | RTLD_GLOBAL);
    if (!module) { fprintf(stderr, "%s\n", dlerror()); return 1; }
    char ***coordinates = dlsym(module, "rtapi_info_address_coordinates");
    if (coordinates) **coordinates = given[2];
    int (*start)(void) = (int (*)(void))dlsym(module, "rtapi_app_main");
    int (*inverse)(const Pose *, double *, const unsigned long *, unsigned long *) =
        (int (*)(const Pose *, double *, const unsigned long *, unsigned long *))dlsym(module, "kinematicsInverse");
    if (!start || !inverse || start()) { fprintf(stderr, "%s does not start\n", given[1]); return 1; }
    for (int i = 3; i < count; i++) {
        char *value = strchr(given[i], '=');
        int known = 0;
        if (!value) return 2;
        *value++ = 0;
        for (int k = 0; k < pin_count; k++)
            if (!strcmp(pins[k].name, given[i])) known = 1, *(double *)pins[k].cell = atof(value);
        if (!known) { fprintf(stderr, "no pin %s\n", given[i]); return 1; }
    }
    Pose pose = {0};
    while (scanf("%lf %lf %lf %lf %lf %lf", &pose.x, &pose.y, &pose.z, &pose.a, &pose.b, &pose.c) == 6) {
        double joints[16] = {0};
        unsigned long inverse_flags = 0, forward_flags = 0;
        if (inverse(&pose, joints, &inverse_flags, &forward_flags)) return 1;
        printf("%.15g %.15g %.15g\n", joints[0], joints[1], joints[2]);
    }
    return 0;
}
