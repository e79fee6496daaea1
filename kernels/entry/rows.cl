/* The stages from samples to bands as one program: a compiler reads its own headers and ours once, not three times. */
#include "kernels/entry/shade.cl"
#include "kernels/entry/resolve.cl"
#include "kernels/entry/integrate_bands.cl"
