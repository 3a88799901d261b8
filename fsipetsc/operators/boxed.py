def Box(record):
    return record
