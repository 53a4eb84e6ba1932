//! The end of the log, found without reading all of it.
//!
//! Counters rise from page to page, and fall once in the ring: behind the end. Half of what is left to search is ruled out
//! by each page that is looked at; the last page is read whole. This file and `mod.rs` are two halves of [`Log`].

use embedded_storage_async::nor_flash::NorFlash;

use super::{ERASED, End, Entry, FAILURES, Log, LogError};

/// Which page to look at next.
struct Search {
    pages: u32,
    /// Counter of the first entry of `page`, once there is one: pages with entries that are not older are ahead of the end.
    oldest: Option<u32>,
    /// The last page that is known to have such entries.
    page: u32,
    /// The first page behind it that is known to have none.
    behind: u32,
}

impl Search {
    /// The next page; `None` when the last one is found.
    fn next(&self) -> Option<u32> {
        let next = match self.oldest {
            // The first page may be free. A log without any entry is looked at page by page.
            None => self.page,
            Some(_) if self.behind - self.page > 1 => u32::midpoint(self.page, self.behind),
            // A page that does not give its entries back any more must not hide the one behind it.
            Some(_) => self.behind + 1,
        };
        (next < self.pages).then_some(next)
    }

    /// Takes the counter of the first entry in page `next`, and returns whether the search is over.
    fn take(&mut self, next: u32, first: Option<u32>) -> bool {
        match (first, self.oldest) {
            (None, None) => self.page += 1,
            (Some(_), None) => self.oldest = first,
            (Some(first), Some(oldest)) if first >= oldest => {
                self.page = next;
                if next > self.behind {
                    self.behind = self.pages;
                }
            }
            _ if next < self.behind => self.behind = next,
            _ => return true,
        }
        false
    }
}

impl<F: NorFlash> Log<F> {
    /// Finds the end.
    ///
    /// # Errors
    /// [`LogError::Read`].
    pub fn end(&mut self) -> Result<End, LogError> {
        let mut search = Search {
            pages: self.pages(),
            oldest: None,
            page: 0,
            behind: self.pages(),
        };
        let mut is_over = false;
        while let Some(next) = search.next().filter(|_| !is_over) {
            let found = self.scan(next, FAILURES + 1)?;
            is_over = search.take(next, found.last.map(|_| found.first));
        }
        if search.oldest.is_none() {
            return Ok(End::default());
        }
        let mut end = self.scan(search.page, Self::PLACES)?;
        if u32::from(end.page()) < self.pages() {
            end.first = self.scan(end.page().into(), FAILURES + 1)?.first;
        }
        Ok(end)
    }

    /// The first so many places of a page: first and last entry, and the place behind the last used one. No more than eight
    /// places before the first entry can have failed.
    fn scan(&mut self, page: u32, places: u32) -> Result<End, LogError> {
        let mut end = End::default();
        for place in page * Self::PLACES..page * Self::PLACES + places {
            let bytes = self.read(place)?;
            if let Some(entry) = Entry::decode(&bytes) {
                end.first = end.last.map_or(entry.counter, |_| end.first);
                end.last = Some(entry);
            } else if bytes == ERASED {
                continue;
            }
            end.place = place + 1;
        }
        Ok(end)
    }
}
