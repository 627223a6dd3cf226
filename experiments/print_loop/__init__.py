"""Does a diagnosis say of a printed robot which links weigh other than designed?"""
