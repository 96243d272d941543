//! Python binding: conversion only.

use pyo3::prelude::*;

#[pymodule]
mod _core {}
