//! An array that takes memory only where it is written.

use std::sync::OnceLock;

/// Entries by number, in pages that appear at the first use.
pub(super) struct Paged<T, const PAGE: usize = 64> {
    pages: Vec<OnceLock<Box<[T]>>>,
}

impl<T: Default, const PAGE: usize> Paged<T, PAGE> {
    pub fn new(count: usize) -> Self {
        let mut pages = Vec::new();
        pages.resize_with(count.div_ceil(PAGE), OnceLock::new);
        Self { pages }
    }
    /// The entry, if its page exists.
    pub fn find(&self, at: usize) -> Option<&T> {
        self.pages[at / PAGE].get().map(|page| &page[at % PAGE])
    }
    /// The entry, for types that are changed through a shared reference.
    pub fn at(&self, at: usize) -> &T {
        &self.pages[at / PAGE].get_or_init(fresh::<T, PAGE>)[at % PAGE]
    }
    /// The entry.
    pub fn at_mut(&mut self, at: usize) -> Option<&mut T> {
        let page = &mut self.pages[at / PAGE];
        page.get_or_init(fresh::<T, PAGE>);
        page.get_mut().map(|page| &mut page[at % PAGE])
    }
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.pages.iter_mut().for_each(|page| *page = OnceLock::new());
    }
    /// Entries of the pages that exist, with their numbers, in order.
    pub fn entries(&self) -> impl Iterator<Item = (usize, &T)> {
        let pages = self.pages.iter().enumerate().filter_map(|(k, page)| page.get().map(|page| (k, page)));
        pages.flat_map(|(k, page)| page.iter().enumerate().map(move |(i, entry)| (k * PAGE + i, entry)))
    }
}

fn fresh<T: Default, const PAGE: usize>() -> Box<[T]> {
    std::iter::repeat_with(T::default).take(PAGE).collect()
}
