"""How far is an image from its reference: relMSE, MSE, PSNR, SSIM and maps of the error."""

from mcdenoise.metrics.errors import mse, psnr, relmse, relmse_map, squared_error_map, ssim

__all__ = ["mse", "psnr", "relmse", "relmse_map", "squared_error_map", "ssim"]
